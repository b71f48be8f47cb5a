import sys; sys.path.insert(0,'/tmp/plastic')
import coverage as c
for s in map(int,sys.argv[1:]): print(c.case(s))
