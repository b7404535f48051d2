"""What follows a learned fold: margins, a second opinion, and feedback from folds that a person measured."""
