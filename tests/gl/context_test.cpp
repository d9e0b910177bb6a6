#include "src/gl/contexts/context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "src/base/error.h"
#include "src/gl/contexts/backends.h"
#include "tests/gl/small_scene.h"

namespace sluice {

// GoogleTest's messages use it.
static void PrintTo(GlChoice choice, std::ostream* out) {
  *out << name(choice);
}

namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr Rgba kBlue{0.25F, 0.5F, 0.75F, 1}, kRed{0.875F, 0.125F, 0, 0.5F}, kGray{2, 2, 2, 1};

// Clear and triangle come back as they were given, float for float.
void expectTriangle(const GlContext& context, Rgba clear, Rgba color) {
  const std::vector<Rgba> pixels = drawTriangle(context, clear, color);
  for (int y = 0; y < kSceneSize; ++y)
    for (int x = 0; x < kSceneSize; ++x) {
      if (x + y == kSceneSize - 1) continue;
      EXPECT_EQ(pixels[static_cast<size_t>(y * kSceneSize + x)],
                x + y < kSceneSize - 1 ? color : clear)
          << context.backend() << " pixel " << x << ", " << y;
    }
}

// Null, and the test skipped by name, if this machine lacks the backend.
std::unique_ptr<GlContext> contextOrSkip(GlChoice choice) {
  try {
    return createContext(choice);
  } catch (const Error& error) {
    [&] { GTEST_SKIP() << error.what(); }();
    return nullptr;
  }
}

std::string errorOf(GlChoice choice, const GlLibraries& libraries) {
  try {
    createContext(choice, libraries);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

class EachBackend : public testing::TestWithParam<GlChoice> {
 protected:
  void SetUp() override { context_ = contextOrSkip(GetParam()); }
  std::unique_ptr<GlContext> context_;
};

TEST_P(EachBackend, drawsIntoAFramebufferAndReadsBack) {
  expectTriangle(*context_, kBlue, kRed);
}

TEST_P(EachBackend, isTheOneAskedForAndACoreProfile) {
  if (GetParam() != GlChoice::kAuto) {
    EXPECT_EQ(context_->backend(), name(GetParam()));
  }
  GLint profile = 0;
  context_->functions().GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
  EXPECT_EQ(profile, GL_CONTEXT_CORE_PROFILE_BIT);
  EXPECT_NE(context_->renderer(), "");
  if (context_->backend() == "osmesa") {
    EXPECT_TRUE(context_->isSoftware());
  }
}

// The least that OpenGL 3.3 allows (its tables of implementation-dependent values).
TEST_P(EachBackend, reportsLimitsThatGlAllows) {
  const GlLimits& limits = context_->limits();
  EXPECT_GE(limits.max_3d_texture_size, 256);
  EXPECT_GE(limits.max_texture_size, 1024);
  EXPECT_GE(limits.max_viewport_size, 1024);
  EXPECT_GE(limits.max_texture_units, 16);
}

TEST_P(EachBackend, knowsItsExtensions) {
  const GlFunctions& gl = context_->functions();
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  ASSERT_GT(count, 0);
  for (GLint i = 0; i < count; ++i) {
    const auto* const text =
        reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)));
    EXPECT_TRUE(context_->has(text)) << text;
  }
  EXPECT_FALSE(context_->has("GL_SLUICE_no_such_extension"));
  EXPECT_FALSE(context_->has(""));
}

// In 8-bit arithmetic each value between two neighbours would be one of the two. A GPU's weights
// have at least 8 bits.
TEST_P(EachBackend, samplesBetweenEightBitValues) {
  constexpr int kCount = 16;
  const std::vector<float> values = sampleAcross(*context_, 10, 11, kCount);
  for (int i = 0; i < kCount; ++i) {
    const double between = std::clamp((i + 0.5) / kCount * 2 - 0.5, 0.0, 1.0);
    EXPECT_NEAR(values[static_cast<size_t>(i)], 10 + between, 1.0 / 128) << "sample " << i;
  }
}

TEST_P(EachBackend, twoOfOneBackendTakeTurns) {
  const auto other = createContext(GetParam());
  for (int turn = 0; turn < 3; ++turn) {
    context_->makeCurrent();
    expectTriangle(*context_, kBlue, kRed);
    other->makeCurrent();
    expectTriangle(*other, kRed, kGray);
  }
}

TEST_P(EachBackend, outlivesAnotherOfItsBackend) {
  createContext(GetParam());
  context_->makeCurrent();
  expectTriangle(*context_, kBlue, kRed);
}

TEST_P(EachBackend, movesToAnotherThread) {
  context_->release();
  std::thread([&] {
    context_->makeCurrent();
    expectTriangle(*context_, kBlue, kRed);
    context_->release();
  }).join();
  context_->makeCurrent();
  expectTriangle(*context_, kRed, kBlue);
}

// Objects belong to the context they were made in, not to the last one created.
TEST_P(EachBackend, keepsItsObjectsWhileOthersDraw) {
  const GlFunctions& gl = context_->functions();
  const std::array<unsigned char, 4> written{1, 2, 3, 4};
  GLuint buffer = 0;
  gl.GenBuffers(1, &buffer);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffer);
  gl.BufferData(GL_ARRAY_BUFFER, written.size(), written.data(), GL_STATIC_DRAW);
  for (const GlChoice choice : {GlChoice::kOsmesa, GlChoice::kEgl}) {
    const auto other = contextOrSkip(choice);
    if (other == nullptr) return;
    EXPECT_FALSE(other->functions().IsEnabled(GL_SCISSOR_TEST));
    GLuint others = 0;
    other->functions().GenBuffers(1, &others);
    other->functions().BindBuffer(GL_ARRAY_BUFFER, others);
    other->functions().BufferData(GL_ARRAY_BUFFER, 4, nullptr, GL_STATIC_DRAW);
  }
  context_->makeCurrent();
  std::array<unsigned char, 4> read{};
  gl.GetBufferSubData(GL_ARRAY_BUFFER, 0, read.size(), read.data());
  EXPECT_EQ(read, written);
}

INSTANTIATE_TEST_SUITE_P(Gl, EachBackend,
                         testing::Values(GlChoice::kAuto, GlChoice::kOsmesa, GlChoice::kEgl),
                         [](const auto& choice) { return std::string(name(choice.param)); });

TEST(GlContext, backendsWorkOneAfterTheOther) {
  for (const GlChoice choice :
       {GlChoice::kOsmesa, GlChoice::kEgl, GlChoice::kOsmesa, GlChoice::kEgl}) {
    const auto context = contextOrSkip(choice);
    if (context == nullptr) return;
    expectTriangle(*context, kBlue, kRed);
  }
}

TEST(GlContext, backendsWorkSideBySide) {
  const auto osmesa = contextOrSkip(GlChoice::kOsmesa);
  const auto egl = osmesa == nullptr ? nullptr : contextOrSkip(GlChoice::kEgl);
  if (egl == nullptr) return;
  for (int turn = 0; turn < 3; ++turn) {
    osmesa->makeCurrent();
    expectTriangle(*osmesa, kBlue, kRed);
    egl->makeCurrent();
    expectTriangle(*egl, kRed, kGray);
  }
}

TEST(GlContext, backendsWorkOnTwoThreadsAtOnce) {
  const auto osmesa = contextOrSkip(GlChoice::kOsmesa);
  const auto egl = osmesa == nullptr ? nullptr : contextOrSkip(GlChoice::kEgl);
  if (egl == nullptr) return;
  egl->release();
  std::thread other([&] {
    egl->makeCurrent();
    for (int i = 0; i < 20; ++i) expectTriangle(*egl, kRed, kGray);
    egl->release();
  });
  osmesa->makeCurrent();
  for (int i = 0; i < 20; ++i) expectTriangle(*osmesa, kBlue, kRed);
  other.join();
}

TEST(GlContext, autoFallsBackOnWhatIsThere) {
  GlLibraries no_osmesa, no_egl;
  no_osmesa.osmesa = {"libNoSuchMesa.so.1"};
  no_egl.egl = {"libNoSuchEgl.so.1"};
  if (contextOrSkip(GlChoice::kOsmesa) == nullptr || contextOrSkip(GlChoice::kEgl) == nullptr)
    return;
  EXPECT_EQ(createContext(GlChoice::kAuto, no_egl)->backend(), "osmesa");
  EXPECT_EQ(createContext(GlChoice::kAuto, no_osmesa)->backend(), "egl");
}

TEST(GlContext, looksForTheLibraryUnderEachName) {
  if (contextOrSkip(GlChoice::kOsmesa) == nullptr) return;
  GlLibraries libraries;
  libraries.osmesa.insert(libraries.osmesa.begin(), "libNoSuchMesa.so.1");
  expectTriangle(*createContext(GlChoice::kOsmesa, libraries), kBlue, kRed);
}

TEST(GlContext, saysWhichLibraryIsMissingAndWhatToInstall) {
  GlLibraries none;
  none.osmesa = {"libNoSuchMesa.so.1"};
  none.egl = {"libNoSuchEgl.so.1"};
  EXPECT_THAT(errorOf(GlChoice::kOsmesa, none),
              AllOf(HasSubstr("--gl osmesa"), HasSubstr("libNoSuchMesa.so.1"),
                    HasSubstr("libosmesa6"), Not(HasSubstr("egl")), Not(HasSubstr("\n"))));
  EXPECT_THAT(errorOf(GlChoice::kEgl, none),
              AllOf(HasSubstr("--gl egl"), HasSubstr("libNoSuchEgl.so.1"), HasSubstr("libegl1"),
                    Not(HasSubstr("osmesa")), Not(HasSubstr("\n"))));
  EXPECT_THAT(errorOf(GlChoice::kAuto, none),
              AllOf(HasSubstr("--gl auto"), HasSubstr("libNoSuchMesa.so.1"),
                    HasSubstr("libNoSuchEgl.so.1"), Not(HasSubstr("\n"))));
}

TEST(GlContext, refusesALibraryThatIsAnother) {
  GlLibraries math;
  math.osmesa = math.egl = {"libm.so.6"};
  EXPECT_THAT(errorOf(GlChoice::kOsmesa, math),
              AllOf(HasSubstr("libm.so.6"), HasSubstr("OSMesaCreateContextAttribs")));
  EXPECT_THAT(errorOf(GlChoice::kEgl, math),
              AllOf(HasSubstr("libm.so.6"), HasSubstr("eglGetProcAddress")));
}

TEST(GlContext, printsNothing) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  for (const GlChoice choice : {GlChoice::kAuto, GlChoice::kOsmesa, GlChoice::kEgl}) {
    try {
      createContext(choice);
    } catch (const Error&) {  // a backend that is missing is silent too
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

// A context of no library that records its calls.
class RecordingContext : public GlContext {
 public:
  RecordingContext(std::string name, std::vector<std::string>& log)
      : GlContext("test", ""), name_(std::move(name)), log_(log) {}
  ~RecordingContext() override { release(); }
  void refuse(bool refuses) { refuses_ = refuses; }

 protected:
  void bind() override {
    log_.push_back("bind " + name_);
    if (refuses_) fail("refused");
  }
  void unbind() noexcept override { log_.push_back("unbind " + name_); }

 private:
  const std::string name_;
  std::vector<std::string>& log_;
  bool refuses_ = false;
};

TEST(GlContext, letsGoBeforeAnotherTakesTheThread) {
  std::vector<std::string> log;
  {
    RecordingContext a("a", log), b("b", log);
    a.makeCurrent();
    a.makeCurrent();  // costs nothing
    b.makeCurrent();
    a.release();  // not the thread's
    a.makeCurrent();
  }
  EXPECT_THAT(log, ElementsAre("bind a", "unbind a", "bind b", "unbind b", "bind a", "unbind a"));
}

TEST(GlContext, isNotCurrentWhenItsLibraryRefuses) {
  std::vector<std::string> log;
  {
    RecordingContext a("a", log);
    a.refuse(true);
    EXPECT_THROW(a.makeCurrent(), Error);
    a.refuse(false);
    a.makeCurrent();
  }
  EXPECT_THAT(log, ElementsAre("bind a", "bind a", "unbind a"));
}

TEST(GlEnvironment, keepsTheUsersFlags) {
  const char* const before = std::getenv("GALLIVM_PERF");
  const std::string kept = before == nullptr ? "" : before;
  setenv("GALLIVM_PERF", "nopt", 1);
  setenv("EGL_LOG_LEVEL", "debug", 1);
  prepareGlEnvironment();
  prepareGlEnvironment();
  EXPECT_STREQ(std::getenv("GALLIVM_PERF"), "nopt");
  EXPECT_STREQ(std::getenv("EGL_LOG_LEVEL"), "debug");
  unsetenv("GALLIVM_PERF");
  unsetenv("EGL_LOG_LEVEL");
  prepareGlEnvironment();
  EXPECT_STREQ(std::getenv("GALLIVM_PERF"), "no_aos_sampling");
  EXPECT_STREQ(std::getenv("EGL_LOG_LEVEL"), "fatal");
  if (before != nullptr) setenv("GALLIVM_PERF", kept.c_str(), 1);
}

TEST(GlEnvironment, softwareGlGetsMoreThreadsThanProcessorsUnlessTheUserSays) {
  const char* const before = std::getenv("LP_NUM_THREADS");
  const std::string kept = before == nullptr ? "" : before;
  setenv("LP_NUM_THREADS", "3", 1);
  prepareGlEnvironment();
  EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "3");
  unsetenv("LP_NUM_THREADS");
  prepareGlEnvironment();
  const int threads = std::atoi(std::getenv("LP_NUM_THREADS"));
  EXPECT_GE(threads, std::min(16, 4 * static_cast<int>(std::thread::hardware_concurrency())));
  EXPECT_LE(threads, 16) << "llvmpipe takes no more";
  if (before != nullptr) setenv("LP_NUM_THREADS", kept.c_str(), 1);
}

}  // namespace
}  // namespace sluice
