# For ctest: ranks of a team wait for each other at every front of a factorization, actively, so that beside other tests they
# take ten times as long, and the others too.
set_tests_properties(pipeline/Ranks.TeamsGiveTheSameDatabase pipeline/Shells.RanksTeamsAndInterruptionsChangeNothing
  PROPERTIES PROCESSORS 3)
