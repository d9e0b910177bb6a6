#include "io/headers/described_volume.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "io/files/file_list.h"
#include "io/headers/decoded_file.h"
#include "io/headers/raw/raw_source.h"
#include "src/base/error.h"
#include "src/base/values/fnv1a.h"

namespace sluice {
namespace {

constexpr size_t kFirstHeadBytes = 64 * 1024;
constexpr size_t kMostHeadBytes = 16 * 1024 * 1024;
// A volume of more files than this opens them only to read.
constexpr int64_t kMostFilesOpen = 64;

std::vector<std::shared_ptr<File>> openFiles(const std::shared_ptr<File>& header,
                                             const FileSet& names) {
  if (names.attached()) return {header};
  const std::filesystem::path folder = std::filesystem::path(header->path()).parent_path();
  const int64_t count = names.count();
  const File::Keep keep = count > kMostFilesOpen ? File::Keep::kClosed : File::Keep::kOpen;
  std::vector<std::shared_ptr<File>> files;
  for (int64_t i = 0; i < count; ++i) {
    const std::filesystem::path path = folder / names.name(i);
    try {
      files.push_back(std::make_shared<File>(path, keep));
    } catch (const Error& error) {
      fail("{}: data file {}", header->path(), error.what());
    }
  }
  return files;
}

// The offset behind `lines` line feeds.
uint64_t skipLines(File& file, uint64_t offset, int64_t lines) {
  std::vector<std::byte> chunk(lines > 0 ? kFirstHeadBytes : 0);
  for (int64_t left = lines; left > 0;) {
    const size_t got = file.readSome(offset, chunk);
    if (got == 0) fail("{}: {} lines to skip, {} found", file.path(), lines, lines - left);
    size_t used = 0;
    while (used < got && left > 0)
      if (chunk[used++] == std::byte{'\n'}) --left;
    offset += used;
  }
  return offset;
}

std::string identityOf(const File& header, const std::vector<std::shared_ptr<File>>& files,
                       const std::string& selection) {
  std::string identity = header.identity();
  if (files.size() == 1 && files[0].get() != &header) identity += "|" + files[0]->identity();
  if (files.size() > 1) {
    uint64_t hash = kFnv1aStart;
    for (size_t i = 0; i < files.size(); ++i)
      hash = fnv1a(files[i]->identity(sampledPages(i, files.size())) + "\n", hash);
    identity += fmt::format("|{} files {:016x}", files.size(), hash);
  }
  return selection.empty() ? identity : identity + "|" + selection;
}

// The offset at which the voxels of a raw file start.
uint64_t rawOffset(const File& file, uint64_t start, const VolumeDescription& description,
                   uint64_t wanted, int64_t files) {
  const uint64_t size = file.sizeBytes();
  const bool at_end = description.byte_skip == VolumeDescription::kSkipToEnd;
  const uint64_t skip = at_end ? 0 : static_cast<uint64_t>(description.byte_skip);
  // Subtracted step by step, so that no sum can wrap.
  if (size < wanted || size - wanted < start || size - wanted - start < skip)
    fail("{}: {} expected, {} found; the file was truncated or its header is wrong", file.path(),
         sizeArithmetic(description.layout, static_cast<int64_t>(start + skip), files), size);
  return at_end ? size - wanted : start + skip;
}

}  // namespace

std::string readHead(File& file, const std::function<bool(std::string_view)>& complete) {
  std::string text;
  size_t wanted = kFirstHeadBytes;
  for (;;) {
    const size_t have = text.size();
    text.resize(wanted);
    const size_t got = file.readSome(have, std::as_writable_bytes(std::span(text)).subspan(have));
    text.resize(have + got);
    // Headers have no length of their own: read on until the end is there.
    if (text.size() < wanted || complete(text)) return text;
    if (wanted >= kMostHeadBytes)
      fail("{}: no end of the header within the first {} bytes", file.path(), kMostHeadBytes);
    wanted *= 4;
  }
}

std::unique_ptr<VolumeSource> openDescribed(std::shared_ptr<File> header,
                                            const VolumeDescription& description,
                                            const std::string& selection,
                                            const DecodeOptions& decode) {
  VolumeLayout layout = description.layout;
  layout.name = std::filesystem::path(header->path()).filename().string();
  layout.path = header->path();
  const int64_t bytes = checkedVolumeBytes(header->path(), layout);
  const std::vector<std::shared_ptr<File>> files = openFiles(header, description.files);
  const int64_t count = static_cast<int64_t>(files.size());
  SLUICE_CHECK_EQ(volume(layout.dims) * layout.time_steps % count, 0);
  const uint64_t wanted = static_cast<uint64_t>(bytes / count);  // bytes of each file

  std::vector<RawSegment> segments;
  std::vector<EncodedFile> encoded;
  for (const std::shared_ptr<File>& file : files) {
    const uint64_t front = description.files.attached() ? description.data_offset : 0;
    const uint64_t start = skipLines(*file, front, description.line_skip);
    const uint64_t skip = static_cast<uint64_t>(std::max<int64_t>(description.byte_skip, 0));
    if (description.encoding == Encoding::kRaw)
      segments.push_back({file, rawOffset(*file, start, description, wanted, count)});
    else if (description.encoding == Encoding::kDeflate)
      encoded.push_back({file, start, skip, wanted});
    else
      encoded.push_back({file, start + skip, 0, wanted});
  }
  std::endian order = description.byte_order;
  if (!encoded.empty()) {
    const bool text = description.encoding == Encoding::kText;
    if (text) order = std::endian::native;
    const int64_t skip = text ? 0 : description.byte_skip;
    segments.push_back(
        {std::make_shared<DecodedFile>(std::move(encoded), text ? Codec::kText : Codec::kDeflate,
                                       layout.type, sizeArithmetic(layout, skip, count), decode),
         0});
  }
  const std::string identity = identityOf(*header, files, selection);
  if (description.files.attached()) header = nullptr;  // counted as the data file
  return std::make_unique<RawSource>(std::move(layout), order, std::move(segments),
                                     std::move(header), identity);
}

}  // namespace sluice
