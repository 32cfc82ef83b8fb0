"""Each engine against analytic answers: scenes in .wms, executed through the stage; `table` lists what is expected."""
