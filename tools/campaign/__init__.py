"""Random scenes run three ways: Adaptive, Newmark extrapolated, and a formulation in SciPy.

``python -m tools.campaign scenes --seeds 0:3000 --workers 2 --out failures``
"""
