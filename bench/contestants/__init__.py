"""One program per library: the same tasks, each written as that library's own documentation would."""
