// Claims about the model.txt of every family.
#pragma once

#include <gtest/gtest.h>

#include "small_model.hpp"

namespace phynness::test {

/// Instantiated in model_text_refuses_damage.cpp.
class ModelTextOf : public testing::TestWithParam<Family> {};

}  // namespace phynness::test
