#include "src/view/state/files/folder_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include "src/base/files/numbered_name.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

unsigned char lower(char letter) {
  return static_cast<unsigned char>(std::tolower(static_cast<unsigned char>(letter)));
}

bool endsIn(const std::string& name, const std::vector<std::string>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const std::string& end) {
    return name.size() > end.size() &&
           std::equal(end.begin(), end.end(), name.end() - static_cast<std::ptrdiff_t>(end.size()),
                      [](char a, char b) { return static_cast<unsigned char>(a) == lower(b); });
  });
}

bool isBefore(const FolderEntry& a, const FolderEntry& b) {
  if (a.is_folder != b.is_folder) return a.is_folder;
  const auto compared = std::lexicographical_compare_three_way(
      a.name.begin(), a.name.end(), b.name.begin(), b.name.end(),
      [](char x, char y) { return lower(x) <=> lower(y); });
  // Names that differ in case alone still need an order.
  return compared == 0 ? a.name < b.name : compared < 0;
}

// The last number of a name, except numbers that describe the contents (256x256x64, uint8).
std::optional<DigitRun> countedIn(const std::string& name) {
  const auto number = lastDigits(name);
  if (!number) return std::nullopt;
  const std::string_view before = std::string_view(name).substr(0, number->at);
  // "uint8" and "256x256x64" tell the form of a raw file and count no steps.
  if (before.ends_with("int") || before.ends_with("float")) return std::nullopt;
  if (before.size() > 1 && before.ends_with('x') && isDigit(before[before.size() - 2]))
    return std::nullopt;
  return number;
}

// Escapes % in a printf pattern.
std::string escaped(const std::string& text) {
  std::string made;
  for (const char letter : text) made += letter == '%' ? std::string("%%") : std::string(1, letter);
  return made;
}

}  // namespace

std::vector<FolderEntry> joinedSeries(std::vector<std::string> names) {
  struct Member {
    std::string name;
    DigitRun number;
  };
  // Names of a series agree in what stands before and behind the number.
  std::map<std::pair<std::string, std::string>, std::vector<Member>> series;
  std::vector<FolderEntry> entries;
  const auto addFile = [&](const std::string& name) { entries.push_back({name, name}); };
  for (std::string& name : names) {
    const auto number = countedIn(name);
    if (!number) {
      addFile(name);
      continue;
    }
    const auto key = std::pair(name.substr(0, number->at), name.substr(number->at + number->size));
    series[key].push_back({std::move(name), *number});
  }
  for (const auto& [around, members] : series) {
    size_t least = SIZE_MAX;
    for (const Member& member : members) least = std::min(least, member.number.size);
    // Longer numbers than the shortest are those that its digits do not hold: no zeros in front.
    const bool is_padded = std::all_of(members.begin(), members.end(), [&](const Member& member) {
      return member.number.size == least || member.name[member.number.at] != '0';
    });
    if (members.size() < 2 || !is_padded) {
      for (const Member& member : members) addFile(member.name);
      continue;
    }
    const std::string name = escaped(around.first) +
                             (least > 1 ? fmt::format("%0{}d", least) : std::string("%d")) +
                             escaped(around.second);
    entries.push_back({name, name, false, static_cast<int64_t>(members.size())});
  }
  std::sort(entries.begin(), entries.end(), isBefore);
  return entries;
}

FolderList readFolder(const FolderQuestion& question, const std::stop_token& stop) {
  FolderList list;
  try {
    fs::path folder = fs::absolute(question.folder.empty() ? "." : question.folder);
    folder = folder.lexically_normal();
    // A trailing slash would count as a further level when going up.
    if (!folder.has_filename() && folder.has_relative_path()) folder = folder.parent_path();
    list.folder = folder.string();
    std::vector<std::string> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (stop.stop_requested()) break;
      const std::string name = entry.path().filename().string();
      // Hidden files are not offered; a path that is typed opens them anyway.
      if (name.starts_with('.')) continue;
      // The entry may be deleted between the listing and the question.
      std::error_code gone;
      const bool opens = endsIn(name, question.ends);
      if (entry.is_directory(gone))
        // Stores such as Zarr are folders and open as volumes.
        list.entries.push_back({name, entry.path().string(), !opens});
      else if (opens)
        files.push_back(name);
    }
    std::vector<FolderEntry> found;
    if (question.joins_series)
      found = joinedSeries(std::move(files));
    else
      for (const std::string& name : files) found.push_back({name, name});
    for (FolderEntry& entry : found) {
      entry.path = (folder / entry.path).string();
      list.entries.push_back(std::move(entry));
    }
    std::sort(list.entries.begin(), list.entries.end(), isBefore);
  } catch (const fs::filesystem_error& error) {
    list.failure = fmt::format("{}: {}", list.folder, error.code().message());
  } catch (const std::exception& error) {
    list.failure = fmt::format("{}: {}", list.folder, error.what());
  }
  return list;
}

FolderReader::FolderReader(std::function<void()> on_list) : on_list_(std::move(on_list)) {}

FolderReader::~FolderReader() {
  const MutexLock lock(mutex_);
  // A reader that hangs on a network folder is not waited for longer than its current entry.
  stop_.request_stop();
}

void FolderReader::ask(const FolderQuestion& question) {
  const MutexLock lock(mutex_);
  stop_.request_stop();
  // An answer to the folder before is not wanted any more.
  stop_ = std::stop_source();
  list_.reset();
  // The question is copied into the task, because the window changes its own while the folder is
  // read.
  worker_.submit([this, number = ++asked_, question, stop = stop_.get_token()] {
    answer(number, question, stop);
  });
}

void FolderReader::answer(uint64_t number, const FolderQuestion& question,
                          const std::stop_token& stop) {
  if (stop.stop_requested()) return;
  FolderList list = readFolder(question, stop);
  {
    const MutexLock lock(mutex_);
    // Another question came while this folder was read.
    if (number != asked_ || stop.stop_requested()) return;
    answered_ = number;
    list_ = std::move(list);
  }
  // Outside of the lock, which the receiver takes in take().
  if (on_list_) on_list_();
}

std::optional<FolderList> FolderReader::take() {
  const MutexLock lock(mutex_);
  return std::exchange(list_, std::nullopt);
}

bool FolderReader::isReading() const {
  const MutexLock lock(mutex_);
  return answered_ != asked_;
}

}  // namespace sluice
