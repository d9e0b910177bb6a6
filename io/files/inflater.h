// Inflater: the decoded bytes of a deflated stream inside a file, from its start to its end.
//
// Holds a fixed 256 KiB of input and zlib's window, whatever the stream contains. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "io/files/decoder.h"
#include "io/files/file.h"

namespace sluice {

class Inflater : public Decoder {
 public:
  // A gzip or zlib stream starts at `offset`; its first bytes tell which of the two it is.
  Inflater(std::shared_ptr<File> file, uint64_t offset);
  // A stream without a header, as zip files have them: `bytes` from `offset` on.
  Inflater(std::shared_ptr<File> file, uint64_t offset, uint64_t bytes);
  ~Inflater() override;
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  // gzip members that follow one another are one stream; bytes after the last one are ignored, as
  // gzip does. A wrong checksum is damage.
  size_t read(std::span<std::byte> out) override;
  bool finished() const override { return finished_; }

 private:
  struct State;
  Inflater(std::shared_ptr<File> file, uint64_t offset, uint64_t bytes, int window);
  bool fillInput();
  void startNextMember();

  const std::shared_ptr<File> file_;
  uint64_t offset_;  // offset of the first byte not yet in the input buffer
  uint64_t left_;    // bytes from there on that may belong to the stream
  const bool has_members_;
  bool finished_ = false;
  const std::unique_ptr<State> state_;
};

}  // namespace sluice
