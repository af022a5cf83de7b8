"""The tour: what `maviper demo` hands out.

Does: puts profile, code, proved region and report of a demo into one folder.
Assumes: a compiled and verified profile.
Does not: extract, decide or print (cli/tour.py does).
"""
