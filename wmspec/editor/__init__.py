"""Help for those who write specs: a language server, a page that redraws on save, first specs, grammars for editors."""
