import sys; sys.path[:0]=['tests','tests/integrate']
import numpy as np, test_steperror as t
from aoimpact.integrate import steperror
for r in (range(300),range(225)):
    cases=[c for s in r if (c:=t.case_of(s)) is not None]
    out=[]
    for share in (0.0,steperror.AROUND_PEAK,.98):
        keep=steperror.AROUND_PEAK; steperror.AROUND_PEAK=share
        c,tr=t.claimed_and_true(cases); steperror.AROUND_PEAK=keep
        out.append(((tr>c+1e-9).mean(),np.median(c/np.maximum(tr,1e-9)), (tr<2*c+1e-9).all()))
    print(r,out,out[0][1]/out[1][1])
