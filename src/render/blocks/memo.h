// Memo: the last value of a pure function, kept for as long as the same is asked of it.
//
// The key holds the function's inputs, so nothing is ever reset explicitly: other inputs give
// another value. One thread.
#pragma once

#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace sluice {

// Stands in a key for an immutable value: equal for the same object and no other, ever, and without
// keeping it alive.
template <class T>
class Identity {
 public:
  Identity(const std::shared_ptr<const T>& of) : of_(of) {}  // NOLINT: stands for it in a key
  friend bool operator==(const Identity& a, const Identity& b) {
    return !a.of_.owner_before(b.of_) && !b.of_.owner_before(a.of_);
  }

 private:
  std::weak_ptr<const T> of_;
};

// `Value` is const but for objects that fill themselves as they are asked.
template <class Key, class Value>
class Memo {
 public:
  using Pointer = std::shared_ptr<Value>;

  // Calls make(), which returns a Value or a Pointer, if the key differs from the last one. The old
  // value is dropped first, so that two are never held at once.
  template <class Make>
  Pointer of(Key key, Make&& make) {
    if (value_ != nullptr && *key_ == key) return value_;
    value_.reset();
    key_ = std::move(key);
    if constexpr (std::is_convertible_v<decltype(make()), Pointer>)
      value_ = make();
    else
      value_ = std::make_shared<Value>(make());
    return value_;
  }

 private:
  std::optional<Key> key_;
  Pointer value_;  // null until made, and if making it failed
};

}  // namespace sluice
