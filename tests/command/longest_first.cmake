# For ctest: the last tests of all, so that the longest ones begin early and no processor waits at the end.
set_tests_properties(command/UnwritableText.EndsNoStageOfARun command/Overwriting.OfInputsIsRefusedByEveryCommand
  PROPERTIES COST 100)
