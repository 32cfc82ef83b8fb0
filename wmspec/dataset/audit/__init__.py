"""Is a dataset what it promises: complete, balanced, free of duplicates and of shortcuts?"""
