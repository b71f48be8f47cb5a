"""Truth: infinite elastic layer (full elastodynamics) under Hertz's law, by convolution quadrature."""
import numpy as np
from scipy.optimize import brentq
def Hdyn(k,s,E,nu,rho,t):
    mu=E/2/(1+nu); cs2=mu/rho; cp2=2*mu*(1-nu)/(1-2*nu)/rho; h=t/2
    xi=np.sqrt(k*k+s*s/cp2); et=np.sqrt(k*k+s*s/cs2); R=(k*k+et*et)**2
    tx,te=np.tanh(xi*h),np.tanh(et*h)
    top=s*s/cs2*xi/mu
    return .5*top*(1/(R/tx-4*k*k*xi*et/te)+1/(R*tx-4*k*k*xi*et*te))
def Mdyn(k,s,E,nu,rho,t,kappa=5/6):
    """Mindlin's plate."""
    D=E*t**3/12/(1-nu*nu); S=kappa*E/2/(1+nu)*t; m=rho*t; I=rho*t**3/12
    # (S k^2 + m s^2) w + S k th = p ; S k w + (D k^2 + S + I s^2) th =0 (signs squared)
    a=D*k*k+S+I*s*s
    return a/((S*k*k+m*s*s)*a-S*S*k*k)
def Gs(s,E,nu,rho,t,a,kind='layer',N=1500):
    """(1/2pi) int p^2 [H(k,s) - H_half(k)] k dk, vectorised over s."""
    k=np.exp(np.linspace(np.log(1e-2),np.log(60/min(a,t)),N)); w=np.gradient(np.log(k))*k
    x=k*a; p2=np.where(x<1e-2,1-x*x/5,(3*(np.sin(x)-x*np.cos(x))/np.maximum(x,1e-9)**3)**2)
    out=np.empty(len(s),complex)
    for i,si in enumerate(s):
        if kind=='layer':
            f=Hdyn(k,si,E,nu,rho,t)-2*(1-nu*nu)/(E*k)
            # cancellation at large kt is harmless
        elif kind=='mindlin': f=Mdyn(k,si,E,nu,rho,t)
        else:
            D=E*t**3/12/(1-nu*nu); f=1/(D*k**4+rho*t*si*si)
        out[i]=(p2*f*k*w).sum()/2/np.pi
    return out
def impact(G,mass,kH,v,dt=2e-7,T=30e-6):
    """G(s) vectorised, without the indentation of Hertz's law kH."""
    n=int(T/dt); L=2*n; rad=(1e-12)**(1/L)
    z=rad*np.exp(2j*np.pi*np.arange(L)/L); de=1-z+.5*(1-z)**2
    s=de/dt
    half=L//2+1; g=G(s[:half]); full=np.concatenate([g,np.conj(g[1:L-half+1][::-1])])
    w=(np.fft.fft(full).real/L)*rad**(-np.arange(L)); w=w[:n]
    # ball by the same BDF2 of its double integral: conv with 1/(m s^2)
    gb=1/(mass*s**2); wb=(np.fft.fft(gb).real/L)*rad**(-np.arange(L)); wb=wb[:n]
    W=w+wb; F=np.zeros(n)
    for i in range(n):
        d0=v*i*dt-np.dot(W[1:i+1],F[:i][::-1]) if i else 0.
        F[i]=0 if d0<=0 else brentq(lambda f:(max(f,0)/kH)**(2/3)+W[0]*f-d0,0,500.)
    return F
if __name__=='__main__':
    E,nu,rho,R=210e9,.3,7800,.005; m=4/3*np.pi*R**3*rho
    for rigid,ts in ((True,(2e-3,)),(False,(1e-3,2e-3,4e-3,8e-3))):
        k=4/3*E/.91*np.sqrt(R)/(1 if rigid else 2)
        for t in ts:
            row=[]
            for kind in ('kirchhoff','mindlin','layer'):
                F=impact(lambda s:Gs(s,E,nu,rho,t,3e-4,kind),m,k,1.); row.append(F.max())
            print(rigid,t,[round(float(x),2) for x in row],'at',F.argmax()*.2,flush=True)
