// Traces written into a folder of the test's own, and read from text.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>

#include "cache/trace/trace.h"
#include "src/base/error.h"

namespace sluice {

class TraceFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              fmt::format("sluice_trace_{}_{}", getpid(),
                          testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const Trace& trace, TraceFormat format, const std::string& file) {
    const auto path = folder_ / file;
    const auto writer = makeTraceWriter(path, format, trace.page_bytes);
    for (const TraceRecord& r : trace.records) writer->write(r);
    writer->finish();
    return path;
  }
  static std::string contentOf(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::filesystem::path folder_;
};

inline Trace read(std::string content, TraceFormat format, uint64_t page_bytes = 4096) {
  const auto reader = makeTraceReader(std::make_unique<std::istringstream>(std::move(content)), "t",
                                      format, page_bytes);
  return readAll(*reader);
}

}  // namespace sluice
