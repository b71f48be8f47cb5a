import sys; sys.path.insert(0,'/tmp/plastic')
import coverage as c,numpy as np
z=[];
for s in range(8,2000,10):
    r=c.case(s)
    if isinstance(r[2],str): print(r); continue
    z.append(r[2][0][1])
z=np.array(z); print(len(z),np.mean(abs(z)<2),z.mean(),z.std(),np.sort(z)[[0,1,2,-3,-2,-1]])
