// KeptAddresses: addresses, without memory behind them, that nothing else takes while this lives.
// Where addresses are limited (`ulimit -v`) they tell whether there are enough for what comes, and
// keep them for it.
#pragma once

#include <cstddef>

namespace sluice {

class KeptAddresses {
 public:
  explicit KeptAddresses(size_t bytes);
  ~KeptAddresses();
  KeptAddresses(const KeptAddresses&) = delete;
  KeptAddresses& operator=(const KeptAddresses&) = delete;

  // False: the system does not give as many in one piece.
  bool areThere() const { return at_ != nullptr; }

 private:
  const size_t bytes_;
  void* const at_;
};

}  // namespace sluice
