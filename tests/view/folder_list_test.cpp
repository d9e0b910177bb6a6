#include "src/view/state/files/folder_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::HasSubstr;

std::vector<std::string> namesOf(const std::vector<FolderEntry>& entries) {
  std::vector<std::string> names;
  for (const FolderEntry& entry : entries)
    names.push_back((entry.is_folder ? "[" : "") + entry.name +
                    (entry.files > 1 ? " x" + std::to_string(entry.files) : ""));
  return names;
}

void touch(const std::filesystem::path& path) {
  std::ofstream(path) << "x";
}

TEST(FolderList, joinsNumberedFilesToAPattern) {
  const auto joined = [](const std::vector<std::string>& names) {
    return namesOf(joinedSeries(names));
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(joined({"s_001.nrrd", "s_002.nrrd", "s_010.nrrd"}), Names({"s_%03d.nrrd x3"}));
  EXPECT_EQ(joined({"s9.raw", "s10.raw", "s11.raw"}), Names({"s%d.raw x3"}));
  // Like printf: numbers may be longer than asked for, without zeros in front.
  EXPECT_EQ(joined({"s_99.raw", "s_100.raw"}), Names({"s_%02d.raw x2"}));
  EXPECT_EQ(joined({"s_01.raw", "s_001.raw"}), Names({"s_001.raw", "s_01.raw"}));
  // A single file is no series; two series are two entries.
  EXPECT_EQ(joined({"a1.png", "b1.png", "b2.png", "plain.nrrd"}),
            Names({"a1.png", "b%d.png x2", "plain.nrrd"}));
  // A number that describes the file does not count the series.
  EXPECT_EQ(joined({"h_4x4x4_uint8.raw", "h_4x4x4_uint16.raw"}),
            Names({"h_4x4x4_uint16.raw", "h_4x4x4_uint8.raw"}));
  EXPECT_EQ(joined({"h_4x4x4.raw", "h_4x4x8.raw"}), Names({"h_4x4x4.raw", "h_4x4x8.raw"}));
  EXPECT_EQ(joined({"50%_1.nrrd", "50%_2.nrrd"}), Names({"50%%_%d.nrrd x2"}));
}

TEST(FolderList, hasFoldersAndWhatOpens) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "sub");
  std::filesystem::create_directories(folder / "store.zarr");
  std::filesystem::create_directories(folder / ".hidden");
  for (const char* name : {"Head.NRRD", "notes.txt", "it's 100%.nii.gz", ".secret.nrrd", "t_1.vdb",
                           "t_2.vdb", "\xc3\xa9t\xc3\xa9.nrrd"})
    touch(folder / name);
  FolderQuestion question;
  question.folder = (folder / "sub" / "..").string() + "/";
  question.ends = {".nrrd", ".nii.gz", ".vdb", ".zarr"};
  const FolderList list = readFolder(question);
  EXPECT_EQ(list.failure, "");
  EXPECT_EQ(list.folder, std::filesystem::absolute(folder / "sub").parent_path().string());
  EXPECT_EQ(namesOf(list.entries),
            std::vector<std::string>({"[sub", "Head.NRRD", "it's 100%.nii.gz", "store.zarr",
                                      "t_%d.vdb x2", "\xc3\xa9t\xc3\xa9.nrrd"}));
  EXPECT_EQ(list.entries[1].path, list.folder + "/Head.NRRD");
  question.joins_series = false;
  EXPECT_EQ(readFolder(question).entries.size(), 7U);
}

TEST(FolderList, saysWhatCannotBeRead) {
  const TempFolder folder;
  FolderQuestion question;
  question.folder = (folder / "nothing").string();
  EXPECT_THAT(readFolder(question).failure, HasSubstr("nothing: No such file or directory"));
  touch(folder / "file");
  question.folder = (folder / "file").string();
  EXPECT_THAT(readFolder(question).failure, HasSubstr("file: Not a directory"));
}

TEST(FolderReader, answersTheNewestQuestion) {
  const TempFolder folder;
  for (const char* name : {"a", "b", "c"}) std::filesystem::create_directories(folder / name);
  Mutex mutex;
  Condition told;
  int times = 0;
  FolderReader reader([&] {
    const MutexLock lock(mutex);
    ++times;
    told.notifyAll();
  });
  FolderQuestion question;
  for (const char* name : {"a", "b", "c"}) {
    question.folder = (folder / name).string();
    reader.ask(question);
  }
  std::optional<FolderList> list;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!(list = reader.take()) && std::chrono::steady_clock::now() < until)
    std::this_thread::yield();
  // An older one may have been answered in time; the newest comes last.
  while (list->folder != question.folder && std::chrono::steady_clock::now() < until)
    if (auto next = reader.take()) list = std::move(next);
  EXPECT_EQ(list->folder, question.folder);
  EXPECT_FALSE(reader.isReading());
  EXPECT_FALSE(reader.take());
}

}  // namespace
}  // namespace sluice
