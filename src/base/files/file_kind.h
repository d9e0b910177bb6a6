// FileKind: the kinds of files that sluice writes, and how an existing file is recognised as one.
//
// A file that the user names for an output may replace an older output of the same kind without
// being asked for, and nothing else: a report replaces a report of ours, not a package.json. The
// name of the existing file tells nothing about its contents, so the contents are looked at. Every
// writer therefore marks its files; the marks are listed in one table (file_kind.cpp), which the
// command line and the window share. Plain functions, any thread.
#pragma once

#include <filesystem>
#include <string>

namespace sluice {

enum class FileKind {
  kPng,
  kExr,
  kReport,            // JSON
  kPage,              // HTML
  kTable,             // CSV of `simulate`
  kTrace,             // any of the trace formats
  kView,              // a view that the window saves, with its path
  kTransferFunction,  // JSON
  kLog,               // written by the window
  kFilm,              // MP4
  kNrrd,              // header and voxels, or the header of a detached file
  kMetaImage,
  kPly,  // meshes
  kStl,
  kObj,
  kRaw,  // voxels without a header: never known to be ours
};

// "a report of sluice", for messages.
std::string nameOf(FileKind kind);

// The text by which PNG, EXR, HTML, NRRD, MetaImage, PLY, STL, OBJ and MP4 files of ours are known,
// in the field that their format has for the name of a program: "sluice VERSION".
std::string softwareMark();

// Whether a new file of this kind may replace the one at `path` without --force: there is nothing,
// an empty file, a device or a pipe, or a file that sluice wrote as this kind. False for a folder
// and for a file that cannot be read. Follows symbolic links. Reads the beginning of the file; of
// JSON all, up to 64 MiB.
bool mayReplace(const std::filesystem::path& path, FileKind kind);

}  // namespace sluice
