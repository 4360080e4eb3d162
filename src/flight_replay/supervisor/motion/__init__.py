"""How targets brake, how fast one with much drag follows, and motions that nothing asked for."""
