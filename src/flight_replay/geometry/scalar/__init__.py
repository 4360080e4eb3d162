"""Lines of few points, number by number: mypyc compiles it in wheels, and for so few numpy is slower.

Lines and points are lists of rows of two or three metres, as of ``tolist``; over the ground up is 0.
"""
