"""Shares of the tolerance of a run, the limits beyond which none is claimed, and why.

The measurements are over random impacts and scenes with a known answer; the tests repeat some of
them on fewer. Two more tolerances are shared out elsewhere: that of a quantity of interest among
models, time and mesh, by accuracy/choice.py; that of a run among what a step does wrong, in the
core, by csrc/adaptive (the table in csrc/README.md).
"""

from __future__ import annotations

import numpy as np

# The smallest tolerance that may be given: double precision has no more digits.
TIGHTEST = 1e-13

# The smallest with which a run still errs less than with a larger one: it shows how well a run at
# TIGHTEST does.
FLOOR = 0.01 * TIGHTEST

# A contact, or a touch, with less than this share of the largest one's peak or impulse is measured
# by that share: whether bodies that move on side by side graze each other is rounding. The core
# has the same rule (step.h).
LESSER = 0.01

# The relative error of a run with fixed steps from which on no digit is claimed.
NO_DIGIT = 0.2

# Where two adaptive runs differ by more than this, errors do not grow as their causes do, and no
# digit is claimed. With a third of this 1.3 % more steps are taken; with seven times as much a
# scene of 784 touches is given up that another run confirms. Chaos is seen with three times as
# much, too; with 1, an error of 0.07 is claimed where two runs differ by 0.27.
LINEAR = 0.03

# Newmark's error estimate: the share of the peak force above which the force itself is compared
# between two steps, since the difference of two peaks may vanish by chance. Over 1488 impacts the
# true error exceeds the estimate in 0.7 % (at most 1.8 times); 0.95 gives 1.5 % (3.6 times), and
# comparing all of the force makes the median estimate 9 times the error instead of 5.6.
AROUND_PEAK = 0.8

# The finest precision to which a contact with friction draws its stretches, as a share of the
# largest: some 700 springs, 1150 of a ball that has rolled for 1800 periods of its tangential
# vibration, each of which leaves two, and the core has room for 2048. An impact's friction errs by
# 0.01 to 0.14 of the precision along one line, and by up to 0.7 of it where the slide turns.
DRAWN = 1e-5

# Safety factor of two adaptive runs. The one with the smaller tolerance errs less, in proportion to
# the tolerance but for this factor, by which single contacts miss or exceed theirs. A second run
# with a tolerance smaller by this factor, and by the number of touches, confirms itself unless
# errors multiply. Over 61 scenes of 2 to 58 touches and five tolerances the largest true error is
# 0.19 of the tolerance; with 3 it is 1.7, and 30 costs 8 % more steps.
SPREAD = 10.0

# The share of the tolerance with which a scene of several contacts is run. Bodies that meet after
# other contacts, at a twentieth of their speeds, make twenty times the error of theirs: two of 6000
# scenes were 11 and 17 tolerances off. It costs 13 % more steps over 306 such scenes;
# 0.1 costs 22 %, and in one of 30 scenes of dashpots on a massless point no step meets it at 1e-9.
SEVERAL = 0.3

# Error of a contact by rounding. It adds up over like contacts, and tighter runs share it. The most
# found was 2.0e-15 a bounce, of 200 balls on a floor against their closed form.
ROUNDING = 12.0 * float(np.finfo(float).eps)

# A tighter run has this tolerance at most. Two that are looser may take the same steps through a
# first touch, which is hardly longer than a step; they agree in its error then, which the touches
# after it multiply: in one of 3000 scenes by 1e5. It costs 13 % more steps over 1200 scenes to a
# tolerance of 6e-5, and none from 1e-6 down.
OTHER_STEPS = 1e-7

# A tighter run that takes this many times the steps of the first is ended: twice what a method of
# order 15 needs for fifteen digits. With 3, six of 305 results are lost that another run gives;
# more waits longer for runs that confirm nothing, in proportion.
PATIENCE = 20

# How well friction is followed under any tolerance, as a share of its bound, where directions turn:
# the core draws the stretches of a contact to 4e-6. Of 40 impacts on four bodies, the velocities of
# runs at 1e-6 and at 1e-8 differ by at most 3e-7 of the speed; of a ball that begins to slip at the
# touch itself by 7e-6.
FRICTION = 1e-5

# Energy growth above this factor means a faulty law or run, not integration error.
GAIN = 1.5

# A touch that begins at a smaller share than this of its mean rate begins at no certain time: of
# bodies at rest side by side that a wave reaches. From 0.001 to 0.1 none of 54 chains in front of a
# wall warns; 25 do if all starts are compared.
SUDDEN = 0.01

# Bodies that loads hold together keep a velocity of rounding: it is measured by this share of what
# their contacts' impulse would give the lightest.
AT_REST = 1e-3

# A user's law whose force scatters by a larger share is refused under any tolerance: steps grow
# with its root. A contact takes 3 steps without scatter, 60 with 1e-9, and 6 000 with this share.
ROUGHEST = 1e-5

# Largest scatter of a user's law as a share of the tolerance: above it steps resolve the scatter
# itself. A contact under a force with a wave of 6e-12 m takes up to 800 steps with a scatter of
# 0.05 of a tolerance of 1e-5 to 1e-7, and is not over after 4 million calls of the law with 0.16.
ROUGHEST_SHARE = 0.1
