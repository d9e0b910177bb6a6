#include "src/gl/contexts/lent_context.h"

#include <utility>

namespace sluice {
namespace {

class Lent : public GlContext {
 public:
  explicit Lent(LentContext lent) : GlContext("window", ""), lent_(std::move(lent)) {}
  ~Lent() override { release(); }

  void start() {
    makeCurrent();
    describe(lent_.find);
  }

 protected:
  void bind() override { lent_.make_current(); }
  void unbind() noexcept override { lent_.release(); }

 private:
  const LentContext lent_;
};

}  // namespace

std::unique_ptr<GlContext> createLentContext(LentContext lent) {
  auto context = std::make_unique<Lent>(std::move(lent));
  context->start();
  return context;
}

}  // namespace sluice
