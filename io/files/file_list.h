// Files by name: folders, patterns, natural order, and the status that tells one version of a file
// from another. Plain functions, any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

// File::identity() of a file. Throws Error when it cannot be read.
std::string fileIdentity(const std::filesystem::path& path);
// "<first absolute path>|N more|<hash of all identities>", one line whatever the number. A page
// each of at most kSampledFiles files, evenly spread, goes into the checksums. Requires: paths not
// empty. Throws Error naming the file that is missing.
std::string fileIdentity(const std::vector<std::filesystem::path>& paths);

// The pages that the identity of file `index` of `count` samples (File::identity).
int sampledPages(size_t index, size_t count);
inline constexpr size_t kSampledFiles = 64;

// The order a person expects: runs of digits compare as numbers ("texture-2" before "texture-10").
bool naturalLess(std::string_view a, std::string_view b);

// Whether `name` is a pattern and not a file's name: it has *, ? or [, or a place for one number
// (numbered_name.h) in a component that does not exist, and no file is called so.
bool isPattern(const std::string& name);

// The files and folders that a pattern stands for: for a glob in natural order; for a number (in
// one component of the path) in the order of the numbers, gaps allowed, so that steps of 100 work.
// Throws Error when none matches.
std::vector<std::filesystem::path> expandPattern(const std::string& pattern);

// All entries of a folder except folders and hidden names, in natural order. A device, a pipe or a
// dangling link is included, so that opening it reports it and no slice goes missing in silence.
// Throws Error when the folder cannot be read.
std::vector<std::filesystem::path> listFolder(const std::filesystem::path& folder);

// Throws Error when `files`, found in the folder or by the pattern `name`, are two series or more
// that differ in more than numbers ("001.tif" ... and "head-001.tif" ...), each of two files or
// more: they would make one volume of several. The line gives the pattern of each.
void requireOneSeries(const std::string& name, const std::vector<std::filesystem::path>& files);

// The numbers of files, in order, whose paths differ in one number alone, which goes up. Empty: no
// such series.
std::vector<int64_t> numbersOf(const std::vector<std::filesystem::path>& files);

// A note that names the missing numbers if the files are one series whose numbers go up in equal
// steps but for gaps. nullopt: no gap, or no such series. The files are in order.
std::optional<std::string> gapNote(const std::vector<std::filesystem::path>& files);

// The file to look for if the paths of `files`, in order, differ in one number alone and `count`
// more were expected: the first that is missing between them, else the `count`th after the last, in
// steps as small as the smallest between two of them. nullopt: no such series, or nothing is
// missing and `count` is 0.
std::optional<std::filesystem::path> missingFile(const std::vector<std::filesystem::path>& files,
                                                 int64_t count);

// Sorts names by their numbers if a shell has sorted them as text ("s10" before "s2"). Returns one
// line for people if the order changed, and if it stays different from the order of the numbers.
std::optional<std::string> orderByNumbers(std::vector<std::string>& names);

// The extension in lower case, with its dot: ".tif"; ".nii.gz" for a name that ends so.
std::string lowerExtension(const std::filesystem::path& path);

}  // namespace sluice
