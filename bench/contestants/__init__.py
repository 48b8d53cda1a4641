"""One program per library: the same tasks, each written as in that library's own documentation."""
