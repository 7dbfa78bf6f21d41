"""The pages of the site that `cvrbench leaderboard` makes."""
