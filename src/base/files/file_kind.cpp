#include "src/base/files/file_kind.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "src/base/error.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

constexpr size_t kStartBytes = 64 << 10;       // holds the header of every format but a film's
constexpr size_t kFilmStartBytes = 8 << 20;    // the tables of some 500 000 frames
constexpr uint64_t kMostJsonBytes = 64 << 20;  // reports of long series take a few MiB
constexpr std::string_view kProgram = "sluice ";

// An existing file as the table looks at it.
struct Existing {
  fs::path path;
  std::string start;
};

std::string startOf(const fs::path& path, size_t most_bytes = kStartBytes) {
  std::ifstream file(path, std::ios::binary);
  std::string start(most_bytes, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<size_t>(file.gcount()));
  return start;
}

// Stops at the first entry of the outermost object that has the key and, unless `value` is empty,
// this text as its value.
class EntrySearch : public nlohmann::json_sax<nlohmann::json> {
 public:
  EntrySearch(std::string_view key, std::string_view value) : key_(key), value_(value) {}
  bool isFound() const { return is_found_; }

  bool null() override { return goOn(); }
  bool boolean(bool) override { return goOn(); }
  bool number_integer(number_integer_t) override { return goOn(); }
  bool number_unsigned(number_unsigned_t) override { return goOn(); }
  bool number_float(number_float_t, const string_t&) override { return goOn(); }
  bool string(string_t& text) override {
    is_found_ = is_found_ || (is_key_ && text == value_);
    return goOn();
  }
  bool binary(binary_t&) override { return goOn(); }
  bool start_object(size_t) override {
    is_outer_object_ = is_outer_object_ || depth_ == 0;
    return open();
  }
  bool end_object() override { return close(); }
  bool start_array(size_t) override { return open(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    is_key_ = is_outer_object_ && depth_ == 1 && name == key_;
    is_found_ = is_key_ && value_.empty();
    return !is_found_;
  }
  bool parse_error(size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  bool goOn() {
    is_key_ = false;
    return !is_found_;
  }
  bool open() {
    ++depth_;
    return goOn();
  }
  bool close() {
    --depth_;
    return goOn();
  }

  const std::string_view key_, value_;
  int64_t depth_ = 0;
  bool is_outer_object_ = false;  // the document is an object, not a list
  bool is_key_ = false;           // the next value belongs to the key
  bool is_found_ = false;
};

// Whether the file is a JSON object, or begins with one, that has this entry.
bool hasEntry(const Existing& file, std::string_view key, std::string_view value) {
  const size_t first = file.start.find_first_not_of(" \t\r\n");
  std::error_code unknown;
  if (first == std::string::npos || file.start[first] != '{' ||
      fs::file_size(file.path, unknown) > kMostJsonBytes || unknown)
    return false;
  std::ifstream in(file.path, std::ios::binary);
  EntrySearch search(key, value);
  // A log has an object a line; lines after the first do not matter. A long report takes no memory
  // as a stream of events.
  nlohmann::json::sax_parse(in, &search, nlohmann::json::input_format_t::json, false);
  return search.isFound();
}

bool startsAndHas(const Existing& file, std::string_view start, std::string_view mark) {
  return file.start.starts_with(start) && file.start.find(mark) != std::string::npos;
}

std::string marked(std::string_view field) {
  return std::string(field) + std::string(kProgram);
}

bool isPng(const Existing& file) {
  using namespace std::string_view_literals;
  return startsAndHas(file, "\x89PNG\r\n", marked("tEXtSoftware\0"sv));
}

// An attribute is its name, its type, its size in four bytes and its value.
bool isExr(const Existing& file) {
  using namespace std::string_view_literals;
  constexpr std::string_view kAttribute = "software\0string\0"sv;
  const size_t at = file.start.find(kAttribute);
  return file.start.starts_with("\x76\x2f\x31\x01") && at != std::string::npos &&
         file.start.compare(std::min(at + kAttribute.size() + 4, file.start.size()),
                            kProgram.size(), kProgram) == 0;
}

bool isReport(const Existing& file) {
  return hasEntry(file, "sluice", "report");
}

bool isPage(const Existing& file) {
  return startsAndHas(file, "<!DOCTYPE html>", marked("<meta name='generator' content='"));
}

std::string_view firstLine(const Existing& file) {
  const std::string_view start = file.start;
  return start.substr(0, start.find('\n'));
}

bool isTable(const Existing& file) {
  const std::string_view line = firstLine(file);
  return line.starts_with("policy,") && line.find(",compulsory,") != std::string_view::npos &&
         line.find(",modelled_seconds") != std::string_view::npos;
}

// The records of oracleGeneral have no room for a mark; the companion file has one.
bool isTrace(const Existing& file) {
  constexpr std::string_view kText = "sluice-trace 1 page_bytes ", kBinary = "SLTRACE";
  const std::string_view line = firstLine(file);
  return line.starts_with(kText) || line.starts_with(kBinary) ||
         line.starts_with("time,obj_id,obj_size,cluster,pages_of_") ||
         (line.starts_with("0 ") && line.find(kText) != std::string_view::npos) ||
         (file.path.extension() == ".oracleGeneral" &&
          startOf(file.path.string() + ".sluice").starts_with(kBinary));
}

bool isView(const Existing& file) {
  return hasEntry(file, "sluice", "view");
}

bool isTransferFunction(const Existing& file) {
  return hasEntry(file, "sluice_transfer_function", "");
}

bool isLog(const Existing& file) {
  return hasEntry(file, "sluice", "log");
}

// The film's own description of itself lies before its frames.
bool isFilm(const Existing& file) {
  return file.start.find("ftyp") == 4 &&
         startOf(file.path, kFilmStartBytes).find(kProgram) != std::string::npos;
}

bool isNrrd(const Existing& file) {
  return startsAndHas(file, "NRRD000", marked("\n# "));
}

bool isMetaImage(const Existing& file) {
  return startsAndHas(file, "ObjectType = Image\n", marked("\nComment = "));
}

bool isPly(const Existing& file) {
  return startsAndHas(file, "ply\n", marked("\ncomment "));
}

// Its header is 80 bytes, the last of which is zero.
bool isStl(const Existing& file) {
  constexpr size_t kLast = 79;
  return file.start.starts_with(kProgram) && file.start.size() > kLast && file.start[kLast] == 0;
}

bool isObj(const Existing& file) {
  return file.start.starts_with(marked("# "));
}

// Any bytes may be voxels, even those of somebody's only copy.
bool isNever(const Existing&) {
  return false;
}

struct Row {
  FileKind kind;
  std::string_view name;
  bool (*is_ours)(const Existing&);
};

constexpr std::array<Row, 16> kKinds{{
    {FileKind::kPng, "a PNG picture of sluice", isPng},
    {FileKind::kExr, "an OpenEXR picture of sluice", isExr},
    {FileKind::kReport, "a report of sluice", isReport},
    {FileKind::kPage, "a page of sluice", isPage},
    {FileKind::kTable, "a table of sluice", isTable},
    {FileKind::kTrace, "a trace of sluice", isTrace},
    {FileKind::kView, "a view that sluice saved", isView},
    {FileKind::kTransferFunction, "a transfer function of sluice", isTransferFunction},
    {FileKind::kLog, "a log of sluice", isLog},
    {FileKind::kFilm, "a film of sluice", isFilm},
    {FileKind::kNrrd, "an NRRD of sluice", isNrrd},
    {FileKind::kMetaImage, "a MetaImage of sluice", isMetaImage},
    {FileKind::kPly, "a PLY mesh of sluice", isPly},
    {FileKind::kStl, "an STL mesh of sluice", isStl},
    {FileKind::kObj, "an OBJ mesh of sluice", isObj},
    {FileKind::kRaw, "known to be replaceable", isNever},
}};

const Row& rowOf(FileKind kind) {
  const auto* const row = std::find_if(kKinds.begin(), kKinds.end(),
                                       [&](const Row& each) { return each.kind == kind; });
  SLUICE_CHECK(row != kKinds.end());
  return *row;
}

}  // namespace

std::string nameOf(FileKind kind) {
  return std::string(rowOf(kind).name);
}

std::string softwareMark() {
  return marked("") + SLUICE_VERSION;
}

bool mayReplace(const fs::path& path, FileKind kind) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return errno == ENOENT || errno == ENOTDIR;
  if (S_ISDIR(status.st_mode)) return false;
  // Devices and empty files have nothing to lose.
  if (!S_ISREG(status.st_mode) || status.st_size == 0) return true;
  return rowOf(kind).is_ours({path, startOf(path)});
}

}  // namespace sluice
