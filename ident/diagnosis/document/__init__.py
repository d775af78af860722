"""The document of a diagnosis: verdict, sentences, JSON."""
