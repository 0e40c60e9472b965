import sys
from pathlib import Path

if __name__ == "__main__":
    # Neither this package nor marine_model is installed where capytaine is.
    scripts = Path(__file__).resolve().parents[1]
    sys.path[:0] = [str(scripts), str(scripts.parent / "src" / "marine_model")]
    from hydrodynamics.command import main

    sys.exit(main(sys.argv[1:]))
