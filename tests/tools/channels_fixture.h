// The fixture of the tests that draw several channels, and the files that these draw.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/program.h"
#include "tests/tools/script_files.h"

namespace sluice {

// Files of channels by zarr-python and tifffile, which are sought in the system's own Python.
class Channels : public testing::Test {
 protected:
  void SetUp() override {
    if (!copyScriptFiles("channels.py", "numpy, PIL, tifffile, zarr", program_.folder.path()))
      GTEST_SKIP() << "python3 with numpy, pil, tifffile and zarr is missing";
  }
  std::string python(const std::string& arguments) const {
    return program_.inFolder("/usr/bin/python3 " SLUICE_TEST_DIR "/tools/channels.py " + arguments)
        .output;
  }
  // The largest difference of a picture and a sum, as the script prints it.
  double difference(const std::string& arguments, double least = 150) const {
    const std::vector<double> all = differences(arguments, least);
    return all.size() == 1 ? all[0] : -1;
  }
  // The same of several lists, by one start of Python.
  std::vector<double> differences(const std::string& arguments, double least = 150) const {
    std::istringstream lines(python(arguments));
    std::vector<double> all;
    std::string of;
    for (double most = 0, brightest = 0; lines >> most >> of >> brightest;) {
      EXPECT_GT(brightest, least) << arguments;
      all.push_back(most);
    }
    EXPECT_FALSE(all.empty()) << arguments;
    return all;
  }
  void render(const std::string& arguments, const std::string& size = "200x160") const {
    const CommandResult result =
        program_.run("render --force --fit volume --size " + size + " " + arguments);
    ASSERT_EQ(result.status, 0) << result.output;
  }

  const Program program_;
};

// Opacities over the windows, and the colours, as omero has them.
inline constexpr std::array<const char*, 3> kStoredLooks = {
    "--map 00ffff --range 400,3000 --opacities 400:0,3000:0.05",
    "--map 00ff00 --range 400,2000 --opacities 400:0,2000:0.05",
    "--map ff00ff --range 500,5000 --opacities 500:0,5000:0.05"};

}  // namespace sluice
