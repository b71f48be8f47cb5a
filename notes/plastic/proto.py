import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar
from math import pi, sqrt, log, exp
R0=3.175e-3; R=R0/2
D=np.array([20,40,60,80,100,120,150,180,200,230])*1e-6
M={'440C':(200e9,1896e6,[542,1538,2599,3743,4509,5779,7484,9158,10495,11927],(233e-6,12280),55.7e6,
 "0.5 3.8 9.6 15.6 23.8 33.8 47.1 63 77 90.9 100.4 106.1 109.3 110 112.2 112.3 111.7 110.9 108.7 103.2 97.7 90.8 79.8 69.4 56 41.6 30.8 22.1 17.3 12.6",
 "130 1017 1740 2594 3759 5114 6363 7755 8642 9847 10783 11881 12743 13479 14299 14800 15022 15211 15223 14943 14112 12772 11114 9767 8229 7202 6096 5184 4662 4055",(.40,.51)),
'302':(200e9,600e6,[323,851,979,1777,2133,2615,3307,4128,4512,5139],(260e-6,5735),24.0e6,
 "0.4 4.1 10.5 17.1 21.8 30.4 39.8 54.6 68.2 80.7 87.1 90.4 91.9 93.6 94.9 95.1 94.2 94.5 92 87.4 80.9 75.1 67.9 57.2 43.4 32.7 24.4 18 13.6 10.9 9 7.7 6.5 5.8",
 "46 240 603 1076 1435 1725 2527 3149 3536 4094 4449 5047 5371 5756 6193 6261 6620 6839 7034 6864 6817 6580 6227 5622 5001 4414 4115 3493 3429 3000 2564 2358 1945 1673",(.22,.28)),
'alu':(76e9,276e6,[72,394,505,754,976,1204,1522,1561,1833,2274],(320e-6,3086),9.6e6,
 "0.5 3.5 8.8 15.1 18.6 24.9 30.2 38.8 47 57.5 65.8 72.4 76.4 78.4 79.6 80.2 81.4 80.2 78.2 74.2 69.5 64.4 59.7 53.8 45 38.5 30.4 24.2 18.4 14",
 "45 120 140 366 330 688 910 1125 1379 1563 1517 1637 2025 2179 2250 2361 2661 2683 2733 2720 2821 2791 2797 2765 2717 2590 2576 2380 2463 2409",(.17,.18))}
class Law:
    """loading curve F(d), contact radius squared a2(d), by kind; c is yield pressure ratio p_y/p0"""
    def __init__(s,kind,E,R,p0,py=None,unload='area'):
        s.kind=kind;s.E=E;s.R=R;s.p0=p0;s.unload=unload
        s.py=py or 1.61*p0/2.8
        s.k=4/3*E*sqrt(R)
        s.dy=(pi*s.py/(2*E))**2*R; s.Fy=s.k*s.dy**1.5
        s.dp=(3*pi*p0/(4*E))**2*R
    def load(s,d):
        if d<=s.dy: return s.k*d**1.5
        R,p0,dy,Fy,k=s.R,s.p0,s.dy,s.Fy,s.k
        if s.kind=='thornton': return Fy+1.5*k*sqrt(dy)*(d-dy)
        if s.kind=='brake':    # hermite between dy and dp, plastic: pi p0 R(2d-dp)
            return s.hermite(d,s.dp,pi*p0*R*(2*d-s.dp),lambda x:pi*p0*R*(2*x-s.dp))
        if s.kind.startswith('herm'):  # a^2 = 2Rd - R dy, plastic from dp*factor
            dp=float(s.kind[4:])*dy
            return s.hermite(d,dp,0,lambda x:pi*p0*R*(2*x-dy))
        if s.kind=='stronge':
            x=2*d/dy-1; pm=2/3*s.py; L=log(167)
            return pi*R*dy*x*min(pm+(p0-pm)*log(x)/L,p0)
        if s.kind=='tangent': # Hertz until slope 2piRp0, straight on
            dt=(2*pi*R*p0/(1.5*k))**2
            return k*d**1.5 if d<dt else k*dt**1.5+2*pi*R*p0*(d-dt)
        if s.kind=='jg':
            w=d/dy
            return Fy*(exp(-w**(5/12)/4)*w**1.5)+2*pi*R*p0*d*(1-exp(-w**(5/9)/25))
        if s.kind=='brake15':
            dp=s.dp
            x=(d-dy)/(dp-dy); ph=1/np.cosh(x)
            return ph*k*d**1.5+(1-ph)*pi*p0*R*(2*d-dy)
    def hermite(s,d,dp,_,pl):
        if d>=dp: return pl(d)
        h=dp-s.dy;t=(d-s.dy)/h
        f0,m0,f1,m1=s.Fy,1.5*s.Fy/s.dy*h,pl(dp),2*pi*s.R*s.p0*h
        return (2*t**3-3*t*t+1)*f0+(t**3-2*t*t+t)*m0+(3*t*t-2*t**3)*f1+(t**3-t*t)*m1
    def a2(s,d):
        if d<=s.dy: return s.R*d
        if s.kind=='thornton': return s.R*d
        if s.kind=='brake': 
            return s.R*(2*d-s.dp) if d>s.dp else s.R*d
        if s.kind=='tangent':
            dt=(2*pi*s.R*s.p0/(1.5*s.k))**2
            return s.R*d if d<dt else s.R*(2*d-dt)
        return s.R*(2*d-s.dy)
    def reach(s,d):
        F=s.load(d)
        if s.unload=='thornton': return F/(s.k*sqrt(d))
        a=sqrt(s.a2(d))
        if s.unload=='p0': a=sqrt(max(F/(pi*s.p0),s.R*d)) # contact radius from force at p0, at least elastic
        return min(3*F/(4*s.E*a), F/(s.k*sqrt(d)))
    def work(s,d): return quad(s.load,0,d,points=[s.dy] if s.dy<d else None,limit=200)[0]
    def force(s,d,dm):
        if d>=dm: return s.load(d) if d>0 else 0.
        if dm<=s.dy: return s.load(max(d,0))
        r=s.reach(dm);x=1-(dm-d)/r
        return s.load(dm)*x**1.5 if x>0 else 0.
    def e(s,m,v):
        d=brentq(lambda d:s.work(d)-.5*m*v*v,1e-8,2e-2)
        return sqrt(.4*s.load(d)*s.reach(d)/(.5*m*v*v)),d,s.load(d),s.reach(d)
def dyn(law,inc,F):
    inc=np.array(inc.split(),float)*1e6;n=len(inc);t=np.arange(n)*5e-6
    A=pi*(9.525e-3)**2;Z=192e9*A/4865.5
    N=8000;tt=np.linspace(0,t[-1],N);dt=tt[1];s=np.interp(tt,t,inc)
    d=0.;dm=0.;out=[];dd=[]
    for x in s:
        f=law.force(d,dm);out.append(f);dd.append(d)
        d+=dt*2*(x*A-f)/Z;dm=max(d,dm)
    return np.array(out),max(dd)
def report(kind,unload,verbose=1):
    print('=====',kind,unload)
    for n,(E,sy,F,pk,sl,inc,tr,eb) in M.items():
        Es=E/(2*.91)
        F=np.array(F)
        def dev(p0): 
            l=Law(kind,Es,R,p0,py=PY and PY*sy,unload=unload); f=np.array([l.load(x) for x in list(D)+[pk[0]]]); return (f/np.array(list(F)+[pk[1]])-1)*100
        def mx(p0): return np.abs(dev(p0)[3:]).max()
        fit=minimize_scalar(lambda q:((dev(q)[3:])**2).sum(),bounds=(.5*sl/(2*pi*R),2*sl/(2*pi*R)),method='bounded').x
        row=[]
        for lab,p0 in (('2.8sy',2.8*sy),('slope',sl/(2*pi*R)),('fit',fit)):
            l=Law(kind,Es,R,p0,py=PY and PY*sy,unload=unload)
            o,dmx=dyn(l,inc,tr);pf=max(np.array(tr.split(),float))
            eW=sqrt(.4*l.load(pk[0])*l.reach(pk[0])/l.work(pk[0]))
            print(f"{n:5s} {lab:6s} p0/sy={p0/sy:.2f} mx={mx(p0):5.1f}% dyn={100*(o.max()/pf-1):5.1f}% e={eW:.2f} {eb}", np.round(dev(p0)).astype(int) if verbose else '')
    for HV,e0,dent in ((955,.890,None),(709,.8,.35*1.0),(600,None,.45),(494,.7,None),(341,.6,None),(300,None,.54),(232,.5,None)):
        H=9.81*HV/.927*1e6
        l=Law(kind,169e9,1.5e-3,H,unload=unload)
        e,d,F,r=l.e(5.45e-3,2.05)
        # dents: residual cap; contact radius from force; area
        print(f"HV{HV} e={e:.3f} ({e0}) d={d*1e6:.1f}um/dy={l.dy*1e6:.1f}/dp={l.dp*1e6:.1f} F={F:.0f} dent: a2 {2e3*sqrt(l.a2(d)):.3f} F/H {2e3*sqrt(F/pi/H):.3f} resid {(d-r)*1e6:.1f}um ({dent})")
PY=None
if __name__=='__main__':
    import sys
    for k in ('thornton','brake','herm20','herm60','stronge','tangent','jg','brake15'):
        for u in ('area','thornton'):
            report(k,u,u=='area')
