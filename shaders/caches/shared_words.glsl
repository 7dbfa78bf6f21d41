// The copy of a brick's words that a cooperative decoder reads; before the shared sources, which read
// it through cvr_read.
shared uint cvr_shared[CVR_SHARED_WORDS];
