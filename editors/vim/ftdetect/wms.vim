autocmd BufRead,BufNewFile *.wms setfiletype wms
