#include "src/view/drawing/job_queue.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

template <class Task>
const Task* taskOf(const std::optional<Job>& job) {
  return job ? std::get_if<Task>(&job->task) : nullptr;
}

// A fit takes long on a large volume, and the window keeps all moves for it.
TEST(JobQueue, placesAViewAfterAWishThatInterruptedIt) {
  JobQueue queue(0.06);
  queue.noteOpened();
  const uint64_t number = queue.place({});
  const std::optional<Job> placing = queue.next();
  ASSERT_NE(taskOf<PlaceJob>(placing), nullptr);
  queue.wish({});
  EXPECT_TRUE(placing->stop.stop_requested()) << "the preview does not wait";
  queue.noteCancelled(*placing);
  const std::optional<Job> preview = queue.next();
  ASSERT_NE(taskOf<PreviewJob>(preview), nullptr);
  queue.notePicture(*preview->wish, true);
  queue.probe(0.5, 0.5);
  const std::optional<Job> again = queue.next();
  ASSERT_NE(taskOf<PlaceJob>(again), nullptr);
  EXPECT_EQ(taskOf<PlaceJob>(again)->number, number);
  queue.probe(0.2, 0.2);
  EXPECT_FALSE(again->stop.stop_requested()) << "a question waits";
  queue.notePlaced(*taskOf<PlaceJob>(again));
  EXPECT_NE(taskOf<ProbeJob>(queue.next()), nullptr);
}

TEST(JobQueue, placesTheNewestViewAlone) {
  JobQueue queue(0.06);
  queue.noteOpened();
  queue.place({});
  const std::optional<Job> first = queue.next();
  const uint64_t newest = queue.place({});
  EXPECT_TRUE(first->stop.stop_requested());
  queue.notePlaced(*taskOf<PlaceJob>(first));  // it was through before it was stopped
  const std::optional<Job> second = queue.next();
  ASSERT_NE(taskOf<PlaceJob>(second), nullptr);
  EXPECT_EQ(taskOf<PlaceJob>(second)->number, newest);
}

TEST(JobQueue, placesNoViewOfTheVolumeBefore) {
  JobQueue queue(0.06);
  queue.noteOpened();
  queue.place({});
  queue.noteOpened();
  queue.wantReport(false);
  EXPECT_NE(taskOf<ReportJob>(queue.next()), nullptr);
}

// The window waits for the answer to a double click before it asks again.
TEST(JobQueue, answersAQuestionThatAWishInterrupted) {
  JobQueue queue(0.06);
  queue.noteOpened();
  queue.wish({});
  const std::optional<Job> first = queue.next();
  queue.notePicture(*first->wish, true);
  const uint64_t number = queue.probe(0.5, 0.5);
  const std::optional<Job> probing = queue.next();
  ASSERT_NE(taskOf<ProbeJob>(probing), nullptr);
  queue.wish({});
  EXPECT_TRUE(probing->stop.stop_requested()) << "the preview does not wait";
  queue.noteCancelled(*probing);
  const std::optional<Job> preview = queue.next();
  ASSERT_NE(taskOf<PreviewJob>(preview), nullptr);
  queue.notePicture(*preview->wish, true);
  queue.wantReport(false);
  const std::optional<Job> again = queue.next();
  ASSERT_NE(taskOf<ProbeJob>(again), nullptr);
  EXPECT_EQ(taskOf<ProbeJob>(again)->number, number);
  queue.noteProbed(*taskOf<ProbeJob>(again));
  EXPECT_NE(taskOf<ReportJob>(queue.next()), nullptr);
}

TEST(JobQueue, picturesComeBeforeTheVolumeThatReplacesTheirs) {
  JobQueue queue(0.06);
  queue.noteOpened();
  queue.noteSeen();
  queue.save(SavePictureJob{"a.png", {}});
  queue.open({});
  const std::optional<Job> saving = queue.next();
  ASSERT_NE(taskOf<SavePictureJob>(saving), nullptr);
  EXPECT_TRUE(queue.isOpen(taskOf<SavePictureJob>(saving)->volume));
  EXPECT_NE(taskOf<OpenJob>(queue.next()), nullptr);
  queue.noteOpened();
  queue.save(SavePictureJob{"b.png", {}});  // by a caller that does not know of it yet
  EXPECT_FALSE(queue.isOpen(queue.takePicture()->volume));
  queue.noteSeen();
  queue.save(SavePictureJob{"c.png", {}});
  EXPECT_TRUE(queue.isOpen(queue.takePicture()->volume));
}

TEST(JobQueue, namesTheFilesThatItsEndLeavesOut) {
  JobQueue queue(0.06);
  queue.noteOpened();
  FilmWish film;
  film.name = "f_%d.png";
  film.path.turn_frames = 8;
  queue.writeFrames(film);
  queue.noteFrame(*taskOf<FrameJob>(queue.next()));
  queue.save(SavePictureJob{"a.png", {}});
  queue.save(SavePictureJob{"b.png", {}});
  queue.save(SaveTextJob{"t.json", "text", {}});
  EXPECT_NE(taskOf<SaveTextJob>(queue.next()), nullptr);
  const std::optional<Job> saving = queue.next();
  queue.save(SaveTextJob{"u.json", "text", {}});
  queue.end();
  EXPECT_TRUE(saving->stop.stop_requested());
  queue.noteCancelled(*saving);
  EXPECT_NE(taskOf<SaveTextJob>(queue.next()), nullptr) << "a small file is written";
  EXPECT_FALSE(queue.next().has_value());
  EXPECT_EQ(queue.unwritten(),
            (std::vector<std::string>{"a.png is not saved: the window ended first",
                                      "b.png is not saved: the window ended first",
                                      "f_%d.png: 1 of 8 frames are written; the window ended"}));
}

// The window says so for as long as the failed wish is the newest.
TEST(JobQueue, forgetsAFailureOfTheVolumeBefore) {
  JobQueue queue(0.06);
  queue.noteOpened();
  const uint64_t number = queue.wish({});
  queue.noteFailed(*queue.next());
  EXPECT_EQ(queue.status().failed, number);
  queue.noteOpened();
  EXPECT_EQ(queue.status().failed, 0);
}

}  // namespace
}  // namespace sluice
