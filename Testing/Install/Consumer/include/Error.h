#error "TreeAMR has an Error.h of its own"
