// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "choices.hpp"
#include "key_values.hpp"
#include "schema.hpp"

/// The kinds of keys. Each function makes a Key from its path, what is allowed, and `get`: a generic lambda from a
/// (const) case to the option. An option may be std::optional: then an empty one is not written.
namespace stiffront::app {

template <typename T>
struct ContentOf {
  using type = T;
};
template <typename T>
struct ContentOf<std::optional<T>> {
  using type = T;
};
template <typename Get>
using Target = std::decay_t<decltype(std::declval<Get>()(std::declval<Case&>()))>;
template <typename Get>
using Content = typename ContentOf<Target<Get>>::type;

/// A writer that hands what the option holds to `to_text`.
template <typename Get, typename ToText>
auto writer(Get get, ToText to_text) {
  return [get, to_text](const Case& c) -> std::string {
    if constexpr (std::is_same_v<Target<Get>, Content<Get>>) {
      return to_text(get(c));
    } else {
      return get(c) ? to_text(*get(c)) : "";
    }
  };
}

template <typename Get>
Key number(std::string path, Range range, Get get, std::string doc) {
  Key key(std::move(path), range.words("number"), std::move(doc));
  key.read = [range, get](Case& c, const ConfigNode& node, const std::string& p) { get(c) = read_number(node, p, range); };
  key.write = writer(get, [](double x) { return toml_text(x); });
  return key;
}

template <typename Get>
Key integer(std::string path, Range range, Get get, std::string doc) {
  using Integer = Content<Get>;
  if constexpr (sizeof(Integer) < sizeof(std::int64_t)) {
    range.upper = std::min(range.upper, static_cast<double>(std::numeric_limits<Integer>::max()));
  }
  Key key(std::move(path), range.words("integer"), std::move(doc));
  key.read = [range, get](Case& c, const ConfigNode& node, const std::string& p) {
    get(c) = static_cast<Integer>(read_integer(node, p, range));
  };
  key.write = writer(get, [](Integer i) { return toml_text(i); });
  return key;
}

/// One of a few integers.
template <typename Get>
Key integer_of(std::string path, std::vector<int> allowed, std::string expected, Get get, std::string doc) {
  Key key(std::move(path), std::move(expected), std::move(doc));
  key.read = [allowed, get, words = key.expected](Case& c, const ConfigNode& node, const std::string& p) {
    for (const int i : allowed) {
      if (node.type == ConfigNode::Type::integer && node.integer == i) {
        get(c) = i;
        return;
      }
    }
    refuse(node, p, words);
  };
  key.write = writer(get, [](int i) { return toml_text(i); });
  return key;
}

template <typename Get>
Key boolean(std::string path, Get get, std::string doc) {
  Key key(std::move(path), "true or false", std::move(doc));
  key.read = [get](Case& c, const ConfigNode& node, const std::string& p) {
    if (node.type != ConfigNode::Type::boolean) refuse(node, p, "true or false");
    get(c) = node.boolean;
  };
  key.write = writer(get, [](bool b) { return toml_text(b); });
  return key;
}

/// Text that is not empty; an option that holds none is not written.
template <typename Get>
Key text(std::string path, std::string expected, Get get, std::string doc) {
  Key key(std::move(path), std::move(expected), std::move(doc));
  key.read = [get, words = key.expected](Case& c, const ConfigNode& node, const std::string& p) { get(c) = read_string(node, p, words); };
  key.write = writer(get, [](const std::string& s) { return s.empty() ? "" : toml_text(s); });
  return key;
}

/// One of a few words, kept as text.
template <typename Get>
Key word(std::string path, std::vector<std::string> allowed, Get get, std::string doc) {
  Key key = text(std::move(path), quoted_alternatives(allowed), get, std::move(doc));
  key.read = [get, allowed](Case& c, const ConfigNode& node, const std::string& p) { get(c) = read_word(node, p, allowed); };
  return key;
}

/// One value of an enumeration.
template <typename Get>
Key choice(std::string path, Get get, std::string doc) {
  using E = Content<Get>;
  Key key(std::move(path), quoted_alternatives(choice_list<E>()), std::move(doc));
  key.read = [get](Case& c, const ConfigNode& node, const std::string& p) {
    const std::vector<std::string> allowed = choice_list<E>();
    const std::string chosen = read_word(node, p, allowed);
    for (std::size_t i = 0; i < allowed.size(); ++i) {
      if (allowed[i] == chosen) get(c) = static_cast<E>(i);
    }
  };
  key.write = writer(get, [](E e) { return toml_text(choice_word(e)); });
  return key;
}

enum class Empty { refused, allowed };

template <typename Get>
Key numbers(std::string path, std::string expected, Range range, Empty empty, Get get, std::string doc) {
  Key key(std::move(path), std::move(expected), std::move(doc));
  key.read = [get, range, empty, words = key.expected](Case& c, const ConfigNode& node, const std::string& p) {
    get(c) = read_array(node, p, words, empty == Empty::allowed,
                        [&range](const ConfigNode& n, const std::string& at) { return read_number(n, at, range); });
  };
  key.write = writer(get, [](const auto& list) { return toml_text(list); });
  return key;
}

template <typename Get>
Key integers(std::string path, std::string expected, Range range, Empty empty, Get get, std::string doc) {
  using Integer = typename Target<Get>::value_type;
  Key key(std::move(path), std::move(expected), std::move(doc));
  key.read = [get, range, empty, words = key.expected](Case& c, const ConfigNode& node, const std::string& p) {
    get(c) = read_array(node, p, words, empty == Empty::allowed,
                        [&range](const ConfigNode& n, const std::string& at) { return static_cast<Integer>(read_integer(n, at, range)); });
  };
  key.write = writer(get, [](const auto& list) { return toml_text(list); });
  return key;
}

/// Names of species; an empty list is not written.
template <typename Get>
Key names(std::string path, Get get, std::string doc) {
  Key key(std::move(path), "an array of names in quotation marks", std::move(doc));
  key.read = [get, words = key.expected](Case& c, const ConfigNode& node, const std::string& p) {
    get(c) = read_array(node, p, words, false,
                        [](const ConfigNode& n, const std::string& at) { return read_string(n, at, "a name in quotation marks"); });
  };
  key.write = writer(get, [](const std::vector<std::string>& list) { return list.empty() ? "" : toml_text(list); });
  return key;
}

template <typename Get>
Key tolerance(std::string path, Get get, std::string doc) {
  Key key(std::move(path), "a positive number, or a table with one for each species", std::move(doc));
  key.read = [get, words = key.expected](Case& c, const ConfigNode& node, const std::string& p) {
    get(c) = read_tolerance(node, p, words);
  };
  key.write = writer(get, [](const Tolerance& t) { return tolerance_text(t); });
  return key;
}

inline Key required(Key key) {
  key.required = true;
  return key;
}

/// For a default that depends on something else.
inline Key with_default(Key key, std::string note) {
  key.default_note = std::move(note);
  return key;
}

}  // namespace stiffront::app
