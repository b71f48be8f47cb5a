import sys; sys.argv=['x']
from proto import *
import proto
class L2(Law):
    def reach(s,d):
        F=s.load(d); w=d/s.dy
        if w<=1: return d
        r={'ekk':lambda:d*(1-(1-w**-.28)*(1-w**-.69)),
           'jgm':lambda:d*(1-1.02*(1-((w+5.9)/6.9)**-.54)),
           'stronge':lambda:3*F/(4*s.E*sqrt(s.R*(2*d-s.dy))),
           'johnson':lambda:3*F/(4*s.E*sqrt(max(F/(pi*s.p0),s.R*d)))}[s.unload]()
        return r
proto.Law=L2
def ratio():
    E=100e9;R=1e-3
    for q in (1.2,1.6,2,2.5,2.8,3.5,4,6,10):
        l=L2('brake',E,R,q*1e9,py=1.61e9,unload='ekk'); worst=0;mono=9e9;W=0
        for w in np.geomspace(1.0001,300,3000):
            d=w*l.dy;h=1e-6*d;s=(l.load(d+h)-l.load(d-h))/2/h
            worst=max(worst,s*l.reach(d)/l.load(d)/1.5);mono=min(mono,s/(1.5*l.Fy/l.dy))
            W=max(W,l.load(d)/(l.k*d**1.5))
        print(q,l.dp/l.dy,'slope ratio',worst,'min slope',mono,'F/Hertz',W)
ratio()
for k in ('brake','tangent'):
    for u in ('ekk','jgm','stronge','johnson'): report(k,u)
proto.PY=1.61
for k in ('brake','jg','stronge'): report(k,'ekk')
