// What a test measured beside what it allows, for people to read in the test's XML or JSON output.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace treeamr::test
{

/// Records both with their unit, once in a test, and expects the measured number to be the allowed one at most.
inline void expectAtMost(double measured, double allowed, const std::string& unit)
{
  const auto text = [&](double number) {
    char digits[32];
    std::snprintf(digits, sizeof(digits), "%.3g", number);
    return digits + (" " + unit);
  };
  ::testing::Test::RecordProperty("measured", text(measured));
  ::testing::Test::RecordProperty("allowed", text(allowed));
  EXPECT_LE(measured, allowed) << unit;
}

} // namespace treeamr::test
