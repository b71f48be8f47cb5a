import sys; sys.path[:0]=['tests/study']
import time,warnings; import numpy as np; import test_fitlaw as t, aoimpact as ao
warnings.simplefilter('ignore')
import aoimpact.study.fitlaw as fl
n=[0]; o=fl._Problem.misfit
def m(self,x): n[0]+=1; return o(self,x)
fl._Problem.misfit=m
for i in range(14):
    law,given,b=t.CASES[i%7](np.random.default_rng([3,i])); n[0]=0
    s=time.process_time(); f=ao.fit_law(**given); print(i,type(law).__name__,n[0],round(time.process_time()-s,2))
