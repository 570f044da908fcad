// Claims about model.txt that every family meets.
#pragma once

#include <gtest/gtest.h>

#include "small_model.hpp"

namespace phynness::test {

/// Instantiated in model_text_refuses_damage.cpp.
class ModelTextOf : public testing::TestWithParam<Family> {};

}  // namespace phynness::test
