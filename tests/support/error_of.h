// The message of an Error, for tests.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "src/base/error.h"

namespace sluice {

// The line of the Error that `action` must throw. A test failure when it throws none (then "") or
// more than one line of moderate length.
template <class F>
std::string errorOf(F&& action) {
  try {
    action();
  } catch (const Error& error) {
    const std::string line = error.what();
    EXPECT_EQ(line.find_first_of("\n\r"), std::string::npos) << line;
    EXPECT_LT(line.size(), 700U) << line;
    return line;
  }
  ADD_FAILURE() << "no Error thrown";
  return "";
}

}  // namespace sluice
