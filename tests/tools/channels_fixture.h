// Files of several channels, for tests that run the program on them.
#pragma once

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/tools/program.h"

namespace sluice {

// Files of channels by zarr-python and tifffile, which are sought in the system's own Python.
class Channels : public testing::Test {
 protected:
  void SetUp() override {
    if (runCommand("/usr/bin/python3 -c 'import numpy, PIL, tifffile, zarr'").status != 0)
      GTEST_SKIP() << "python3 with numpy, pil, tifffile and zarr is missing";
    ASSERT_EQ(python("write"), "");
  }
  std::string python(const std::string& arguments) const {
    return program_.inFolder("/usr/bin/python3 " SLUICE_TEST_DIR "/tools/channels.py " + arguments)
        .output;
  }
  // The largest difference of a picture and a sum, as the script prints it.
  double difference(const std::string& arguments, double least = 150) const {
    std::istringstream line(python(arguments));
    double most = -1, brightest = 0;
    std::string of;
    line >> most >> of >> brightest;
    EXPECT_GT(brightest, least) << arguments;
    return most;
  }
  void render(const std::string& arguments, const std::string& size = "200x160") const {
    const CommandResult result =
        program_.run("render --force --fit volume --size " + size + " " + arguments);
    ASSERT_EQ(result.status, 0) << result.output;
  }

  const Program program_;
};

}  // namespace sluice
