#include "io/files/file_list.h"

#include <glob.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>
#include <optional>

#include "io/files/file.h"
#include "src/base/error.h"
#include "src/base/files/number_text.h"
#include "src/base/files/numbered_name.h"
#include "src/base/values/fnv1a.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

std::vector<std::filesystem::path> expandGlob(const std::string& pattern) {
  glob_t found{};
  const int status = ::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found);
  std::vector<std::filesystem::path> paths;
  for (size_t i = 0; i < found.gl_pathc; ++i) paths.emplace_back(found.gl_pathv[i]);
  globfree(&found);
  if (status != 0 && status != GLOB_NOMATCH) fail("{}: the folder cannot be read", pattern);
  return paths;
}

// A path with one number in a component, such as the name of a file or of a folder of files.
struct NumberedPath {
  std::filesystem::path folder;  // where the names with numbers are; empty: the current folder
  NumberedName name;
  std::filesystem::path rest;  // what follows in each of them; empty: nothing
};

// nullopt: no component has a number, or more than one. Components that exist are names.
std::optional<NumberedPath> parseNumberedPath(const std::filesystem::path& pattern) {
  NumberedPath path;
  auto part = pattern.begin();
  std::error_code error;
  for (; part != pattern.end(); ++part) {
    const auto numbered = parseNumberedName(part->string());
    if (numbered && !std::filesystem::exists(path.folder / *part, error)) {
      path.name = *numbered;
      break;
    }
    path.folder /= *part;
  }
  if (part == pattern.end()) return std::nullopt;
  while (++part != pattern.end()) {
    if (isNumbered(*part)) return std::nullopt;
    path.rest /= *part;
  }
  return path;
}

// All entries of a folder except hidden names, in natural order.
std::vector<std::filesystem::path> entriesOf(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> entries;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const bool is_hidden = it->path().filename().native().starts_with('.');
    if (!is_hidden) entries.push_back(it->path());
  }
  if (error) fail("{}: the folder cannot be read: {}", folder.string(), error.message());
  std::sort(entries.begin(), entries.end(),
            [](const auto& a, const auto& b) { return naturalLess(a.native(), b.native()); });
  return entries;
}

std::vector<std::filesystem::path> expandNumbers(const NumberedPath& pattern) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : entriesOf(pattern.folder.empty() ? "." : pattern.folder)) {
    if (!pattern.name.matches(entry.filename().string())) continue;
    auto path = pattern.folder / entry.filename();
    if (!pattern.rest.empty()) path /= pattern.rest;
    std::error_code error;
    if (std::filesystem::symlink_status(path, error).type() !=
        std::filesystem::file_type::not_found)
      paths.push_back(std::move(path));
  }
  return paths;
}

// The name with '#' for each run of digits.
std::string withoutNumbers(std::string_view name) {
  std::string result;
  for (const char c : name) {
    if (!isDigit(c))
      result += c;
    else if (result.empty() || result.back() != '#')
      result += '#';
  }
  return result;
}

// The name with its last number as printf would write it: "a-007.png" -> "a-%03d.png".
std::string asPattern(const std::string& name) {
  const auto digits = lastDigits(name);
  if (!digits) return name;
  const bool is_padded = name[digits->at] == '0' && digits->size > 1;
  const std::string number = is_padded ? fmt::format("%0{}d", digits->size) : "%d";
  return name.substr(0, digits->at) + number + name.substr(digits->at + digits->size);
}

}  // namespace

std::string fileIdentity(const std::filesystem::path& path) {
  return File(path).identity();
}

std::string fileIdentity(const std::vector<std::filesystem::path>& paths) {
  if (paths.size() == 1) return fileIdentity(paths[0]);
  std::string all;
  for (size_t i = 0; i < paths.size(); ++i)
    all += File(paths[i]).identity(sampledPages(i, paths.size())) + "\n";
  return fmt::format("{}|{} more|{:016x}",
                     std::filesystem::absolute(paths[0]).lexically_normal().string(),
                     paths.size() - 1, fnv1a(all));
}

int sampledPages(size_t index, size_t count) {
  if (count == 1) return File::kSampledPages;
  const size_t stride = (count + kSampledFiles - 1) / kSampledFiles;
  return index % stride == 0 ? 1 : 0;
}

bool naturalLess(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a, whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (!isDigit(a[0]) || !isDigit(b[0])) {
      if (a[0] != b[0]) return static_cast<unsigned char>(a[0]) < static_cast<unsigned char>(b[0]);
      a.remove_prefix(1);
      b.remove_prefix(1);
      continue;
    }
    const auto takeNumber = [](std::string_view& text) {
      const size_t end = std::min(text.find_first_not_of("0123456789"), text.size());
      std::string_view number = text.substr(0, end);
      text.remove_prefix(end);
      number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
      return number;
    };
    const std::string_view number_a = takeNumber(a), number_b = takeNumber(b);
    // Without leading zeros, the longer number is the greater one.
    if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
    if (number_a != number_b) return number_a < number_b;
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;  // equal but for leading zeros: any fixed order
}

bool isPattern(const std::string& name) {
  std::error_code error;
  if (std::filesystem::exists(name, error)) return false;
  return name.find_first_of("*?[") != std::string::npos || parseNumberedPath(name).has_value();
}

std::vector<std::filesystem::path> expandPattern(const std::string& pattern) {
  const auto numbered = parseNumberedPath(pattern);
  std::vector<std::filesystem::path> paths =
      numbered ? expandNumbers(*numbered) : expandGlob(pattern);
  if (paths.empty()) fail("{}: no file matches this pattern", pattern);
  std::sort(paths.begin(), paths.end(),
            [](const auto& a, const auto& b) { return naturalLess(a.native(), b.native()); });
  return paths;
}

std::vector<std::filesystem::path> listFolder(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files = entriesOf(folder);
  std::erase_if(files, [](const std::filesystem::path& file) {
    std::error_code unknown;
    return std::filesystem::is_directory(file, unknown);
  });
  return files;
}

void requireOneSeries(const std::string& name, const std::vector<std::filesystem::path>& files) {
  struct Series {
    std::string pattern;
    int count = 0;
  };
  std::map<std::string, Series> all;
  for (const auto& file : files) {
    Series& series = all[withoutNumbers(file.filename().string())];
    if (series.count++ == 0) series.pattern = asPattern(file.string());
  }
  std::string list;
  int several = 0;
  for (const auto& [key, series] : all) {
    if (series.count < 2) continue;
    ++several;
    list +=
        fmt::format("{}'{}' ({} files)", list.empty() ? "" : ", ", series.pattern, series.count);
  }
  if (several > 1)
    fail("{}: {} series of files, expected one; name one of {}", name, several, list);
}

namespace {

// The number that a run of digits stands for; nullopt for more than fits.
std::optional<int64_t> numberOfDigits(std::string_view digits) {
  constexpr size_t kMostDigits = 18;  // less than 2^63, also with a step added
  if (digits.size() > kMostDigits) return std::nullopt;
  return numberIn<int64_t>(digits);
}

// Files whose paths differ in one number alone, which goes up.
struct NumberedFiles {
  NumberedName name;
  std::vector<int64_t> numbers;
};

// nullopt: no such files.
std::optional<NumberedFiles> numberedFiles(const std::vector<std::filesystem::path>& files) {
  if (files.size() < 2) return std::nullopt;
  const std::string a = files[files.size() - 2].string(), b = files.back().string();
  // The place of the number is the one at which the last two paths differ, from its first digit on:
  // "099" and "100" already differ there, "108" and "109" only at the end.
  auto begin =
      static_cast<size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).second - b.begin());
  while (begin > 0 && isDigit(b[begin - 1])) --begin;
  NumberedFiles found{{b.substr(0, begin), {}, SIZE_MAX}, {}};
  for (const auto& file : files) {
    const std::string name = file.string();
    if (!name.starts_with(found.name.before)) return std::nullopt;
    const size_t end = std::min(name.find_first_not_of("0123456789", begin), name.size());
    const auto number = numberOfDigits(std::string_view(name).substr(begin, end - begin));
    if (found.numbers.empty()) found.name.after = name.substr(end);
    if (!number || (!found.numbers.empty() && *number <= found.numbers.back()) ||
        name.substr(end) != found.name.after)
      return std::nullopt;
    // Numbers without zeros in front have more digits as they go up.
    found.name.width = std::min(found.name.width, end - begin);
    found.numbers.push_back(*number);
  }
  return found;
}

}  // namespace

std::vector<int64_t> numbersOf(const std::vector<std::filesystem::path>& files) {
  auto found = numberedFiles(files);
  return found ? std::move(found->numbers) : std::vector<int64_t>();
}

std::optional<std::filesystem::path> missingFile(const std::vector<std::filesystem::path>& files,
                                                 int64_t count) {
  const auto found = numberedFiles(files);
  if (!found) return std::nullopt;
  const std::vector<int64_t>& numbers = found->numbers;
  int64_t step = std::numeric_limits<int64_t>::max();
  for (size_t i = 1; i < numbers.size(); ++i) step = std::min(step, numbers[i] - numbers[i - 1]);
  int64_t wanted = numbers.back();  // stays if the number does not fit into its type
  if (count <= (std::numeric_limits<int64_t>::max() - wanted) / step) wanted += count * step;
  for (size_t i = numbers.size() - 1; i > 0; --i)
    if (numbers[i] - numbers[i - 1] > step) wanted = numbers[i - 1] + step;
  if (wanted == numbers.back()) return std::nullopt;
  return found->name.with(wanted);
}

std::optional<std::string> gapNote(const std::vector<std::filesystem::path>& files) {
  const auto found = numberedFiles(files);
  if (!found || files.size() < 3) return std::nullopt;
  const std::vector<int64_t>& numbers = found->numbers;
  std::map<int64_t, size_t> steps;
  for (size_t i = 1; i < numbers.size(); ++i) ++steps[numbers[i] - numbers[i - 1]];
  const auto usual = std::max_element(
      steps.begin(), steps.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const int64_t step = usual->first;
  // Numbers that go up anyhow are no series with gaps. Of three files two are neighbours, and one
  // is missing before the third.
  const bool is_one_of_four = numbers.size() == 3 && steps.contains(2 * step);
  if (usual->second * 3 < (numbers.size() - 1) * 2 && !is_one_of_four) return std::nullopt;
  const std::filesystem::path folder =
      std::filesystem::path(found->name.before + "0").parent_path();
  constexpr int64_t kMostNames = 4;
  std::vector<std::string> names;
  int64_t missing = 0;
  for (size_t i = 1; i < numbers.size(); ++i) {
    const int64_t between = (numbers[i] - numbers[i - 1]) / step - 1;
    for (int64_t k = 1; k <= between && missing + k <= kMostNames; ++k) {
      const std::filesystem::path name = found->name.with(numbers[i - 1] + k * step);
      names.push_back(name.lexically_relative(folder).string());
    }
    missing += between;
  }
  if (missing == 0) return std::nullopt;
  const auto unnamed = missing - static_cast<int64_t>(names.size());
  if (unnamed > 0) names.push_back(fmt::format("{} more", unnamed));
  std::string list = names[0];
  for (size_t i = 1; i < names.size(); ++i)
    list += (i + 1 == names.size() ? " and " : ", ") + names[i];
  return fmt::format("{}: {} {} missing; the files on both sides of a gap become neighbours",
                     folder.empty() ? "." : folder.string(), list,
                     names.size() == 1 ? "is" : "are");
}

std::optional<std::string> orderByNumbers(std::vector<std::string>& names) {
  const auto by_number = [](const std::string& a, const std::string& b) {
    return naturalLess(a, b);
  };
  if (std::is_sorted(names.begin(), names.end(), by_number)) return std::nullopt;
  // Sorted as text, as the shells of most languages do.
  const auto without_case = [](const std::string& a, const std::string& b) {
    const auto less = [](unsigned char x, unsigned char y) {
      return std::tolower(x) < std::tolower(y);
    };
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), less);
  };
  const bool by_shell = std::is_sorted(names.begin(), names.end()) ||
                        std::is_sorted(names.begin(), names.end(), without_case);
  if (!by_shell)
    return fmt::format(
        "{}: the files are taken in the order given, which differs from the order of their numbers",
        names[0]);
  std::sort(names.begin(), names.end(), by_number);
  return fmt::format("{}: the files are taken in the order of their numbers, this one first",
                     names[0]);
}

std::string lowerExtension(const std::filesystem::path& path) {
  const std::filesystem::path lower(lowercase(path.filename().string()));
  std::string extension = lower.extension().string();
  if (extension == ".gz") return lower.stem().extension().string() + extension;
  return extension;
}

}  // namespace sluice
