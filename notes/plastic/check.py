import sys,math,numpy as np; sys.path.insert(0,'/tmp/plastic')
import io,contextlib
with contextlib.redirect_stdout(io.StringIO()):
    from proto2 import *
import aoimpact as ao
steel=ao.Material(E=210e9,nu=.3,rho=7800,yield_strength=600e6)
law=ao.ElasticPlastic.between(steel,.005,steel,math.inf)
print(law,repr(law),law.dent(50e-6),ao.restitution(law,.004,1.0))
print(ao.ElasticPlastic.between(ao.Material(E=210e9,nu=.3,rho=7800,hardness=3e9),.01,steel,.01).plastic_indentation)
y=ao.YangSun(1.413e9,.1667e-3,.094); print(y,y.dent(.3e-3),ao.restitution(y,.0084,1.0),ao.restitution(y,.0084,10.0))
l=L2('brake',169e9,1.5e-3,10e9,unload='ekk')
e=ao.ElasticPlastic(l.k,l.Fy,l.p0,relative_radius=1.5e-3)
d=np.geomspace(1e-7,1e-3,50)
print(np.abs(e.force(d)/[l.load(x) for x in d]-1).max(), max(abs(e._work(x)/l.work(x)-1) for x in d), l.e(5.45e-3,2.05)[0], ao.restitution(e,5.45e-3,2.05))
for law in (e,ao.YangSun(1.413e9,.1667e-3,.094),ao.YangSun(1.413e9,.02e-3)):
  for v in (.1,2,10.):
    for s in (ao.Adaptive(rtol=1e-8),ao.Newmark(dt=2e-8)):
        h=ao.simulate(projectile=ao.rigid(mass=.01),target=ao.rigid(mass=math.inf),law=law,velocity=v,duration=4e-4 if v>1 else 2e-3 ,solver=s)
        print(v,h.restitution,ao.restitution(law,.01,v),h.peak_force,h.cost)
