import sys; sys.path.insert(0,'/tmp/plastic')
import aoimpact as ao, numpy as np
import aoimpact.study.fitlaw as fl
import coverage as c
cap={}
orig=ao.fit_law
def spy(start,**a):
    cap.update(a=a,start=start)
    f=fl.fit_law(start,**a); cap['fit']=f; return f
ao.fit_law=spy
for s in map(int,sys.argv[1:]):
    r=c.case(s); a=cap['a']; f=cap['fit']
    print(r[0],f)
    # truth
    import types
    errs={n:z for n,z,_ in r[2]}
    true={n:(f.start_time if n=='start_time' else getattr(f.law,n))-errs[n]*f.standard_errors[n] for n in errs}
    print('true',true)
    start=cap['start']
    meas=a.get('signal')
    data=fl._measurement(a.get('signal'),a.get('mass'),a.get('velocity'),None,None,a.get('indentation'),a.get('force'),a.get('dent'))
    from dataclasses import replace
    tl=replace(f.law,**{n:v for n,v in true.items() if n!='start_time'})
    m=data.shown(tl,true.get('start_time',0.))-data.measured
    m2=data.shown(f.law,f.start_time or 0.)-data.measured
    print('cost true',(m**2).sum(),'fit',(m2**2).sum(), 'foot',data.start,'sample',data.sample)
    p=fl._Problem(start,fl._free(start,a.get('free')),data)
    print('start',start)
    sol=p.solved(); print(sol.x,sol.cost,sol.message,sol.nfev,sol.optimality, np.exp(sol.x)*p.first)
    for st in 1e-4*np.eye(len(sol.x)): print([float((p.misfit(sol.x+s_*st)**2).sum()) for s_ in(-100,-10,-1,0,1,10,100)])
