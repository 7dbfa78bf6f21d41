#include "codecs/astc/contexts.hpp"

#include <map>
#include <mutex>
#include <new>
#include <vector>

#include "codecs/astc/library.hpp"

namespace cvr::codecs::astc {

namespace {

/// The contexts that nobody uses. They live until the program ends.
class Pool {
 public:
  ~Pool() {
    for (auto& [kind, contexts] : idle_) {
      for (astcenc_context* context : contexts) astcenc_context_free(context);
    }
  }
  astcenc_context* find(const ContextKind& kind) {
    const std::scoped_lock lock(mutex_);
    auto& contexts = idle_[kind];
    if (contexts.empty()) return nullptr;
    astcenc_context* context = contexts.back();
    contexts.pop_back();
    return context;
  }
  void keep(const ContextKind& kind, astcenc_context* context) {
    const std::scoped_lock lock(mutex_);
    idle_[kind].push_back(context);
  }

 private:
  std::mutex mutex_;
  std::map<ContextKind, std::vector<astcenc_context*>> idle_;
};

Pool& pool() {
  static Pool pool;
  return pool;
}

}  // namespace

void GiveBack::operator()(astcenc_context* context) const { pool().keep(kind, context); }

Context take_context(const ContextKind& kind) {
  astcenc_context* context = pool().find(kind);
  if (context == nullptr) {
    const bool decodes = kind.effort == kDecodeOnly;
    astcenc_config config;
    const auto known =
        astcenc_config_init(ASTCENC_PRF_LDR, kind.edge, kind.edge, kind.edge,
                            decodes ? ASTCENC_PRE_FASTEST : static_cast<float>(kind.effort),
                            decodes ? ASTCENC_FLG_DECOMPRESS_ONLY : 0, &config);
    if (known != ASTCENC_SUCCESS || astcenc_context_alloc(&config, 1, &context) != ASTCENC_SUCCESS)
      throw std::bad_alloc();
  }
  return {context, GiveBack{kind}};
}

}  // namespace cvr::codecs::astc
