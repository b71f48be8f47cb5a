import sys,math,numpy as np,warnings,time
import aoimpact as ao
from multiprocessing import Pool
steel=ao.Material(E=210e9,nu=.3,rho=7800,yield_strength=600e6)
def case(seed):
    rng=np.random.default_rng([7,seed])
    kind=['HuntCrossley','Thornton','ElasticPlastic','KelvinVoigt','Tsuji','YangSun','curve EP','curve YS','dents','curve power'][seed%10]
    k=10**rng.uniform(8.5,10); m=10**rng.uniform(-2,0); v=10**rng.uniform(-.3,.7)
    noise=10**rng.uniform(-2.3,-1.)
    hz=ao.Hertz(k); d=hz.stroke(.5*m*v*v); F=hz.force(d)
    R=0.01
    ep=ao.ElasticPlastic(k,F*rng.uniform(.005,.05),1e9,relative_radius=R,) if False else None
    def plastic():
        Fy=F*rng.uniform(.005,.05); dy=(Fy/k)**(2/3); py=1.5/math.pi*k*math.sqrt(dy)/R
        return ao.ElasticPlastic(k,Fy,py*rng.uniform(1.5,2.5),relative_radius=R)
    free=None; start=None
    if kind=='HuntCrossley': law=ao.HuntCrossley(k,rng.uniform(.1,.5)/v); start=ao.HuntCrossley
    elif kind=='Thornton': law=ao.Thornton(k,F*rng.uniform(.05,.5)); start=ao.Thornton
    elif kind=='KelvinVoigt': law=ao.KelvinVoigt.from_restitution(F/d,rng.uniform(.5,.9),m); start=ao.KelvinVoigt
    elif kind=='Tsuji': law=ao.Tsuji.from_restitution(k,rng.uniform(.5,.9),m); start=ao.Tsuji
    elif kind in('YangSun','curve YS'): law=ao.YangSun(k,d*rng.uniform(.1,.6)); start=ao.YangSun
    elif kind=='curve power': law=ao.PowerLaw(k*d**(1.5-1.3),1.3*rng.uniform(.9,1.5)); start=ao.PowerLaw
    else:
        law=plastic(); free=['hardness'] if kind!='curve EP' else ['k','hardness']
        start=ao.ElasticPlastic(law.k*(rng.uniform(.8,1.2) if kind=='curve EP' else 1.),law.yield_force,law.hardness*rng.uniform(1.0,1.2),relative_radius=R)
    if kind.startswith('curve'):
        up=np.linspace(0,d,120); 
        path=np.concatenate([up,up[::-1][1:],up[1:]*1.2])
        f=law.force(path,along=True); f=f+noise*f.max()*rng.normal(size=f.shape)
        args=dict(indentation=path,force=f)
    elif kind=='dents':
        vs=v*np.linspace(.5,2,12)*max(1.,math.sqrt(2*law._work(3*law.plastic_indentation)/m)/v); w=np.array([law.dent(law.stroke(.5*m*x*x)).diameter for x in vs]); w=w+noise*w.mean()*rng.normal(size=w.shape)
        args=dict(dent=w,mass=m,velocity=vs)
    else:
        hit=ao.simulate(ao.rigid(mass=m),ao.rigid(mass=math.inf),v,law=law,solver=ao.Adaptive(rtol=1e-9))
        T=hit.contact_duration; t0=T*rng.uniform(.1,.6)
        t=np.linspace(0,2*T,int(rng.integers(100,400)))
        f=np.zeros(len(t)); w=(t>t0); 
        hit=ao.simulate(ao.rigid(mass=m),ao.rigid(mass=math.inf),v,law=law,duration=2*T,solver=ao.Adaptive(rtol=1e-9))
        f[w]=hit.at(t[w]-t0).force
        f+=noise*F*rng.normal(size=f.shape)
        args=dict(signal=ao.Signal(t,f),mass=m,velocity=v)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        try: fit=ao.fit_law(start,**args,free=free)
        except Exception as e: return kind,seed,'ERR '+repr(e),0
    out=[]
    for n,e in fit.standard_errors.items():
        true=t0 if n=='start_time' else getattr(law,n); got=fit.start_time if n=='start_time' else getattr(fit.law,n)
        out.append((n,(got-true)/e, n in fit.undetermined))
    return kind,seed,out,fit.residual
if __name__=='__main__':
    n=int(sys.argv[1]); first=int(sys.argv[2]) if len(sys.argv)>2 else 0; t=time.time()
    with Pool(2) as p: res=p.map(case,range(first,first+n),chunksize=10)
    from collections import defaultdict
    cov=defaultdict(list); joint=[];bad=[]
    for kind,seed,out,r in res:
        if isinstance(out,str): bad.append((kind,seed,out)); continue
        for nme,z,u in out:
            if not u: cov[kind,nme].append(abs(z)<2)
            else: cov[kind,nme+' UND'].append(abs(z)<2)
            if abs(z)>6 and not u: bad.append((kind,seed,nme,z))
    for k_ in sorted(cov): print(k_,len(cov[k_]),round(100*np.mean(cov[k_]),1))
    allz=[x for k_,l in cov.items() if 'UND' not in k_[1] for x in l]
    print('all',len(allz),100*np.mean(allz)); print(len(bad),bad[:20]); print(time.time()-t)
