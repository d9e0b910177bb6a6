// Descriptor: an open file of the system, closed at the end; and reading and writing one whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

namespace sluice {

class Descriptor {
 public:
  // No descriptor, or the result of open(), where -1 means none too.
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { reset(); }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    reset(std::exchange(other.number_, -1));
    return *this;
  }

  explicit operator bool() const { return number_ >= 0; }
  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }
  // Closes the descriptor that it holds.
  void reset(int number = -1);

 private:
  int number_;
};

// Writes all of `bytes` at the file's position. Throws Error, "<what>: <reason>"; a full disk too.
void writeAll(int descriptor, std::span<const std::byte> bytes, const std::string& what);
// The same from `offset` of the file on.
void writeAllAt(int descriptor, std::span<const std::byte> bytes, uint64_t offset,
                const std::string& what);
// Fills `out` from the file's position on. False when it ends before, or cannot be read.
bool readAll(int descriptor, std::span<std::byte> out);
// Takes the file for this process alone, until it is closed. False: another process has it. Throws
// Error, "<path>: cannot be locked ...": the file system has no locks.
bool lockAlone(int descriptor, const std::string& path);
// Opens a file for reading and writing, made if there is none, and takes it as lockAlone() does.
// Returns none if another process has it. Throws Error as lockAlone() does, which leaves no empty
// file, and "<path>: cannot be written: <reason>". A process that has the file may rename or remove
// it: what is returned still has the name.
Descriptor openAlone(const std::string& path);

}  // namespace sluice
