// Writes one valid header of each version and byte order into the folder given: seeds for the
// fuzzer, which would not find the magic numbers in ten seconds.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace {

class Header {
 public:
  Header(size_t size, bool big_endian) : bytes_(size, '\0'), big_endian_(big_endian) {}
  template <class T>
  void set(size_t offset, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (big_endian_) std::reverse(raw, raw + sizeof(T));
    std::copy(raw, raw + sizeof(T), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  void text(size_t offset, std::string_view value) {
    std::copy(value.begin(), value.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  const bool big_endian_;
};

// 5 x 4 x 3 x 2 i16 with a qform.
std::string nifti1(bool big_endian) {
  Header h(352, big_endian);
  h.set<int32_t>(0, 348);
  h.text(344, "n+1");
  const int16_t dim[] = {4, 5, 4, 3, 2, 1, 1, 1};
  for (size_t i = 0; i < 8; ++i) h.set<int16_t>(40 + 2 * i, dim[i]);
  for (size_t i = 0; i < 8; ++i) h.set<float>(76 + 4 * i, 1);
  h.set<int16_t>(70, 4);
  h.set<int16_t>(72, 16);
  h.set<float>(108, 352);
  h.set<float>(112, 2);
  h.set<int16_t>(252, 1);
  h.set<float>(256, 0.5F);
  return h.bytes();
}

// The same with an sform.
std::string nifti2(bool big_endian) {
  Header h(544, big_endian);
  h.set<int32_t>(0, 540);
  h.text(4, std::string_view("n+2\0\r\n\032\n", 8));
  const int64_t dim[] = {4, 5, 4, 3, 2, 1, 1, 1};
  for (size_t i = 0; i < 8; ++i) h.set<int64_t>(16 + 8 * i, dim[i]);
  for (size_t i = 0; i < 8; ++i) h.set<double>(104 + 8 * i, 1);
  h.set<int16_t>(12, 4);
  h.set<int16_t>(14, 16);
  h.set<int64_t>(168, 544);
  h.set<int32_t>(348, 1);
  for (size_t i = 0; i < 3; ++i) h.set<double>(400 + 40 * i, 1.5);
  return h.bytes();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  for (const bool big_endian : {false, true}) {
    const std::string tail = big_endian ? "_big" : "_little";
    std::ofstream(folder / ("nifti1" + tail), std::ios::binary) << nifti1(big_endian);
    std::ofstream(folder / ("nifti2" + tail), std::ios::binary) << nifti2(big_endian);
  }
  return 0;
}
