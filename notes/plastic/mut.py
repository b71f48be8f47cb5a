import sys; sys.path.insert(0,'tests/c')
import mutants
mutants.MUTANTS[:]=[m for m in mutants.MUTANTS if m[0] in("law/plastic.c","law/laminate.c")]
print(len(mutants.MUTANTS))
sys.exit(mutants.main())
