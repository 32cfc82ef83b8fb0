"""The grammar of the `.wms` language (`wms.lark`)."""
