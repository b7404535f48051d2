"""`python -m tatamu` is the command `tatamu`."""

from tatamu.cli import main

if __name__ == "__main__":
    main()
