#pragma once

#include <exception>
#include <future>
#include <map>
#include <mutex>
#include <string>

namespace brdfit {

/// Values by key that several threads ask for: the first to ask makes one, the others wait for it.
template <typename Value>
class MadeOnce {
  public:
    /// `make` may ask for other keys, but not in a circle. What it throws comes out of here, for
    /// everyone who asks. The value lives as long as this object.
    template <typename Make>
    const Value& get(const std::string& key, Make make) {
        std::promise<Value> promise;
        std::shared_future<Value>* known = nullptr;
        bool first = false;
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            first = values_.find(key) == values_.end();
            known = &values_[key]; // stays where it is
            if (first)
                *known = promise.get_future().share();
        }
        if (first) {
            try {
                promise.set_value(make());
            } catch (...) {
                promise.set_exception(std::current_exception());
            }
        }
        return known->get();
    }

  private:
    std::mutex mutex_;
    std::map<std::string, std::shared_future<Value>> values_;
};

} // namespace brdfit
