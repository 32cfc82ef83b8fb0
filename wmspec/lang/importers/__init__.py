"""Assets: files of several links and joints (URDF), put in the place of the object that names them."""
