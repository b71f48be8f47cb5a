"""Shares of the tolerance of a run that several of its parts know, and why.

The measurements are over random impacts and scenes with a known answer; the tests repeat some of
them on fewer. Two more tolerances are shared out elsewhere: that of a quantity of interest among
models, time and mesh, by accuracy/choice.py; that of a run among what a step does wrong, in the
core, by csrc/adaptive (the table in csrc/README.md).
"""

# The smallest tolerance that may be given: double precision has no more digits.
TIGHTEST = 1e-13

# A contact, or a touch, with less than this share of the largest one's peak or impulse is measured
# by that share: whether bodies that move on side by side graze each other is rounding. The core
# has the same rule (step.h).
LESSER = 0.01

# The finest precision to which a contact with friction draws its stretches, as a share of the
# largest: some 700 springs, 1150 of a ball that has rolled for 1800 periods of its tangential
# vibration, each of which leaves two, and the core has room for 2048. An impact's friction errs by
# 0.01 to 0.14 of the precision along one line, and by up to 0.7 of it where the slide turns.
DRAWN = 1e-5
