import aoimpact as ao, math, numpy as np, time
ball=ao.rigid(mass=.1); wall=ao.rigid(mass=math.inf)
law=ao.HuntCrossley(k=1e9,damping=.2)
hit=ao.simulate(ball,wall,1.0,law=law)
sig=ao.Signal.of(hit,rate=1e6,margin=5e-5)
t=time.perf_counter(); f=ao.fit_law(ao.HuntCrossley,sig,mass=.1,velocity=1.0); print(f, f.residual, f.start_time, time.perf_counter()-t)
rng=np.random.default_rng(0)
noisy=ao.Signal(sig.t+.3,sig.values+30*rng.normal(size=sig.t.shape))
t=time.perf_counter(); f=ao.fit_law(ao.HuntCrossley,noisy,mass=.1,velocity=1.0); print(f, f.residual,f.correlation, time.perf_counter()-t)
for cls in (ao.Thornton,ao.KelvinVoigt,ao.Tsuji,ao.PowerLaw,ao.Flores,ao.YangSun,ao.Linear,ao.Hertz,ao.KuwabaraKono):
    t=time.perf_counter(); f=ao.fit_law(cls,noisy,mass=.1,velocity=1.0); print(f, f.residual, time.perf_counter()-t)
