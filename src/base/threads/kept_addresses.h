// KeptAddresses: addresses, without memory behind them, that nothing else takes while this lives.
// If addresses are limited (`ulimit -v`), it tells whether enough are left for the memory to come,
// and keeps them for it.
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
